#include "tools/view/drag_client.h"

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>

#include <chrono>
#include <deque>
#include <map>

#include "formats/base/error.h"
#include "formats/base/text.h"
#include "tools/view/admission.h"
#include "tools/view/picture_message.h"

namespace rhoray::tools {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using Tcp = asio::ip::tcp;

namespace {

using Clock = std::chrono::steady_clock;

constexpr auto frame_time = std::chrono::microseconds(16'667);
constexpr auto longest_wait = std::chrono::seconds(60);

double ms_between(Clock::time_point begin, Clock::time_point end) {
  return std::chrono::duration<double, std::milli>(end - begin).count();
}

}  // namespace

class DragClient::Implementation {
 public:
  Implementation(const std::string& url, std::uint16_t port) : socket_(context_), timer_(context_) {
    const std::size_t slash = url.find('/', std::string("http://").size());
    const std::string host = url.substr(std::string("http://").size(), slash - std::string("http://").size());
    const std::string token = url.substr(url.find("token=") + 6);
    try {
      beast::get_lowest_layer(socket_).connect({asio::ip::address_v4::loopback(), port});
      beast::get_lowest_layer(socket_).set_option(Tcp::no_delay(true));
      socket_.set_option(websocket::stream_base::decorator([&](websocket::request_type& request) {
        request.set(beast::http::field::origin, "http://" + host);
        request.set(beast::http::field::sec_websocket_protocol, concat(view_protocol, ", ", token));
      }));
      socket_.read_message_max(0);
      socket_.handshake(host, "/ws");
    } catch (const boost::system::system_error& error) {
      throw Error(ErrorCode::resource, concat("no connection to the viewer: ", error.code().message()));
    }
    read();
  }

  DragFigures drag(double seconds, const RequestAt& request, double stall_s) {
    DragFigures figures;
    std::map<std::uint32_t, Clock::time_point> open;  // requests that no picture has shown
    const Clock::time_point begin = Clock::now();
    const auto elapsed = [&] { return 1e-3 * ms_between(begin, Clock::now()); };
    std::uint32_t first_after_stall = 0;
    on_picture_ = [&](const PictureHeader& header, std::size_t bytes) {
      const Clock::time_point now = Clock::now();
      figures.picture_bytes.push_back(static_cast<double>(bytes));
      figures.spacings.push_back(header.spacing);
      if (stall_s > 0 && first_after_stall != 0 && header.request < first_after_stall) ++figures.late_pictures;
      while (!open.empty() && open.begin()->first <= header.request) {
        figures.latencies_ms.push_back(ms_between(open.begin()->second, now));
        open.erase(open.begin());
      }
    };
    const auto send_request = [&] {
      open.emplace(++number_, Clock::now());
      send(concat(R"({"n": )", number_, ", ", request(elapsed()), R"(, "moving": true})"));
    };
    each_frame([&] { return elapsed() < seconds; }, send_request);
    if (stall_s > 0) {
      is_reading_ = false;
      each_frame([&] { return elapsed() < seconds + stall_s; }, send_request);
      first_after_stall = number_;
      is_reading_ = true;
      read();
    }
    run_until([&] { return open.empty(); });
    figures.seconds = elapsed();
    on_picture_ = nullptr;
    return figures;
  }

  Settled settle(const std::string& request) {
    Settled settled;
    const Clock::time_point begin = Clock::now();
    on_picture_ = [&](const PictureHeader& header, std::size_t) {
      if (header.request != number_ || header.spacing > 1) return;
      (header.codec == Codec::png ? settled.lossless_ms : settled.whole_ms) = ms_between(begin, Clock::now());
    };
    send(concat(R"({"n": )", ++number_, ", ", request, "}"));
    run_until([&] { return settled.lossless_ms > 0; });
    on_picture_ = nullptr;
    return settled;
  }

 private:
  /// Calls an action at each frame of the display while a condition holds.
  void each_frame(const std::function<bool()>& goes_on, const std::function<void()>& act) {
    bool has_ended = false;
    std::function<void()> next = [&] {
      if (!goes_on()) {
        has_ended = true;
        return;
      }
      act();
      timer_.expires_at(timer_.expiry() + frame_time);
      timer_.async_wait([&](beast::error_code) { next(); });
    };
    timer_.expires_at(Clock::now());
    next();
    run_until([&] { return has_ended; });
  }

  void run_until(const std::function<bool()>& is_done) {
    const Clock::time_point begin = Clock::now();
    while (!is_done()) {
      context_.restart();
      context_.run_one_for(std::chrono::milliseconds(100));
      if (!failure_.empty()) throw Error(ErrorCode::resource, concat("the viewer is gone: ", failure_));
      if (Clock::now() > begin + longest_wait) throw Error(ErrorCode::resource, "the viewer sends no picture");
    }
  }

  void read() {
    if (!is_reading_ || is_read_pending_) return;
    is_read_pending_ = true;
    socket_.async_read(buffer_, [this](beast::error_code error, std::size_t bytes) {
      is_read_pending_ = false;
      if (error) {
        failure_ = error.message();
        return;
      }
      if (!socket_.got_text()) {
        const PictureHeader header =
            read_picture_header({static_cast<const std::byte*>(buffer_.data().data()), buffer_.size()});
        if (on_picture_) on_picture_(header, bytes);
        send(concat(R"({"ack": )", header.frame, "}"));
      } else if (const std::string text = beast::buffers_to_string(buffer_.data()); text.starts_with(R"({"error")")) {
        failure_ = text;
        return;
      }
      buffer_.consume(buffer_.size());
      read();
    });
  }

  void send(std::string text) {
    waiting_.push_back(std::move(text));
    if (waiting_.size() == 1) write();
  }

  void write() {
    socket_.async_write(asio::buffer(waiting_.front()), [this](beast::error_code error, std::size_t) {
      if (error) {
        failure_ = error.message();
        return;
      }
      waiting_.pop_front();
      if (!waiting_.empty()) write();
    });
  }

  asio::io_context context_;
  websocket::stream<Tcp::socket> socket_;
  asio::steady_timer timer_;
  beast::flat_buffer buffer_;
  std::deque<std::string> waiting_;
  std::function<void(const PictureHeader&, std::size_t bytes)> on_picture_;
  std::string failure_;
  std::uint32_t number_ = 0;
  bool is_reading_ = true, is_read_pending_ = false;
};

DragClient::DragClient(const std::string& url, std::uint16_t port)
    : implementation_(std::make_unique<Implementation>(url, port)) {}
DragClient::~DragClient() = default;

DragFigures DragClient::drag(double seconds, const RequestAt& request, double stall_s) {
  return implementation_->drag(seconds, request, stall_s);
}
DragClient::Settled DragClient::settle(const std::string& request) {
  return implementation_->settle(request);
}

}  // namespace rhoray::tools
