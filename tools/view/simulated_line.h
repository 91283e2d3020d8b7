#pragma once

#include <cstdint>
#include <memory>

namespace rhoray::tools {

/// A line between a client and a server.
struct Line {
  double round_trip_ms = 0;
  double megabits_per_s = 0;  ///< in each direction; 0: no limit
};

/// Passes the bytes of one connection on as a slow line does: no faster than its rate, later by half
/// of its round trip, and at most 64 KiB wait in it in each direction.
class SimulatedLine {
 public:
  /// Listens on the loopback interface.
  /// @param server_port  of the loopback interface, at the other end
  SimulatedLine(std::uint16_t server_port, const Line& line);
  SimulatedLine(const SimulatedLine&) = delete;
  SimulatedLine& operator=(const SimulatedLine&) = delete;
  ~SimulatedLine();

  std::uint16_t port() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace rhoray::tools
