#pragma once

#include <cstdint>
#include <memory>

namespace rhoray::tools {

/// A line between a client and a server.
struct Line {
  double round_trip_ms = 0;
  double megabits_per_s = 0;  ///< in each direction; 0: no limit
};

/// Simulates a slow line for one connection. Each direction has the line's rate and delays bytes by
/// half of the round trip. At most 64 KiB wait in each direction.
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
