#include "tools/view/simulated_line.h"

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

namespace rhoray::tools {

namespace asio = boost::asio;
using Tcp = asio::ip::tcp;

namespace {

using Clock = std::chrono::steady_clock;
using Milliseconds = std::chrono::duration<double, std::milli>;

constexpr std::size_t most_bytes_waiting = std::size_t{64} << 10, chunk_bytes = std::size_t{4} << 10;

/// One direction: one thread takes bytes, another hands them on when they have arrived.
class Direction {
 public:
  Direction(Tcp::socket& from, Tcp::socket& to, const Line& line)
      : from_(from), to_(to), line_(line), taking_([this] { take(); }), giving_([this] { give(); }) {}
  Direction(const Direction&) = delete;
  Direction& operator=(const Direction&) = delete;
  ~Direction() { end(); }

 private:
  struct Chunk {
    std::vector<char> bytes;
    Clock::time_point arrival;
  };

  void take() {
    boost::system::error_code error;
    Clock::time_point free = Clock::now();  // when the line can take the next byte
    for (;;) {
      std::vector<char> bytes(chunk_bytes);
      bytes.resize(from_.read_some(asio::buffer(bytes), error));
      if (error) return end();
      const double ms = line_.megabits_per_s > 0 ? 8e-3 * static_cast<double>(bytes.size()) / line_.megabits_per_s : 0;
      free = std::max(free, Clock::now()) + std::chrono::duration_cast<Clock::duration>(Milliseconds(ms));
      const auto delay = std::chrono::duration_cast<Clock::duration>(Milliseconds(line_.round_trip_ms / 2));
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return has_ended_ || bytes_waiting_ < most_bytes_waiting; });
      if (has_ended_) return;
      bytes_waiting_ += bytes.size();
      waiting_.push_back({std::move(bytes), free + delay});
      changed_.notify_all();
    }
  }

  void give() {
    boost::system::error_code error;
    for (;;) {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return has_ended_ || !waiting_.empty(); });
      if (has_ended_) return;
      const Chunk chunk = std::move(waiting_.front());
      waiting_.pop_front();
      changed_.wait_until(lock, chunk.arrival, [&] { return has_ended_; });
      lock.unlock();
      asio::write(to_, asio::buffer(chunk.bytes), error);
      lock.lock();
      bytes_waiting_ -= chunk.bytes.size();
      changed_.notify_all();
      lock.unlock();
      if (error) return end();
    }
  }

  /// Any thread may call it.
  void end() {
    boost::system::error_code ignored;
    from_.shutdown(Tcp::socket::shutdown_both, ignored);
    to_.shutdown(Tcp::socket::shutdown_both, ignored);
    const std::lock_guard lock(mutex_);
    has_ended_ = true;
    changed_.notify_all();
  }

  Tcp::socket& from_;
  Tcp::socket& to_;
  const Line line_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Chunk> waiting_;
  std::size_t bytes_waiting_ = 0;
  bool has_ended_ = false;
  std::jthread taking_, giving_;
};

}  // namespace

class SimulatedLine::Implementation {
 public:
  Implementation(std::uint16_t server_port, const Line& line)
      : acceptor_(context_, {asio::ip::address_v4::loopback(), 0}), client_(context_), server_(context_) {
    accepting_ = std::jthread([this, server_port, line] {
      boost::system::error_code error;
      acceptor_.accept(client_, error);
      if (!error) server_.connect({asio::ip::address_v4::loopback(), server_port}, error);
      if (error) return;
      for (Tcp::socket* socket : {&client_, &server_}) socket->set_option(Tcp::no_delay(true), error);
      up_.emplace(client_, server_, line);
      down_.emplace(server_, client_, line);
    });
  }
  ~Implementation() {
    boost::system::error_code ignored;
    Tcp::socket last(context_);  // ends the wait for a connection, where none has come
    last.connect({asio::ip::address_v4::loopback(), port()}, ignored);
    accepting_.join();
    up_.reset(), down_.reset();
  }
  std::uint16_t port() const { return acceptor_.local_endpoint().port(); }

 private:
  asio::io_context context_;
  Tcp::acceptor acceptor_;
  Tcp::socket client_, server_;
  std::optional<Direction> up_, down_;
  std::jthread accepting_;
};

SimulatedLine::SimulatedLine(std::uint16_t server_port, const Line& line)
    : implementation_(std::make_unique<Implementation>(server_port, line)) {}
SimulatedLine::~SimulatedLine() = default;

std::uint16_t SimulatedLine::port() const {
  return implementation_->port();
}

}  // namespace rhoray::tools
