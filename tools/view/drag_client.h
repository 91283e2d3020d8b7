#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace rhoray::tools {

/// Measurements of a drag, made by the client.
struct DragFigures {
  std::vector<double> latencies_ms;  ///< of every request: until a picture came that shows it or a newer one
  std::vector<double> picture_bytes;
  std::vector<double> spacings;  ///< of the traced pixels of each picture
  double seconds = 0;
  std::size_t late_pictures = 0;  ///< that came after a stall and show requests from before its end
};

/// A client that behaves as the page does: at most one request for each frame of a display at 60
/// Hz, and an acknowledgement for each picture. It does not decode pictures.
class DragClient {
 public:
  /// The part of a request between its number and its end, as JSON members: "size": [..], ...
  using RequestAt = std::function<std::string(double second)>;

  /// Connects to a server (Server::url) and takes its hello. Refuses a server that does not let it
  /// in (ErrorCode::resource).
  /// @param port  of the loopback interface: the server's own, or that of a line to it
  DragClient(const std::string& url, std::uint16_t port);
  DragClient(const DragClient&) = delete;
  DragClient& operator=(const DragClient&) = delete;
  ~DragClient();

  /// Drags for a time.
  /// @param stall_s  reads nothing for so long before it ends
  DragFigures drag(double seconds, const RequestAt& request, double stall_s = 0);

  /// Times until the whole picture and until the lossless one came, in milliseconds.
  struct Settled {
    double whole_ms = 0, lossless_ms = 0;
  };
  Settled settle(const std::string& request);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace rhoray::tools
