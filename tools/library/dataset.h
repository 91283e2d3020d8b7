#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/descriptor.h"
#include "formats/base/stoppable_mutex.h"
#include "render/load.h"
#include "render/texture.h"
#include "rhoray/dataset.h"

namespace rhoray::v0_1 {

namespace inside {

/// The cells of a mesh with a label.
struct MeshPart {
  std::string field;
  int label = 0;
};

/// Where data come from.
struct Origin {
  bool is_in_memory = false;       ///< of no file that another process could open
  bool is_wrapped = false;         ///< samples are in the caller's memory
  std::optional<MeshPart> part{};  ///< of which they are the boundary
};

}  // namespace inside

class Dataset::Implementation {
 public:
  /// @param memory  of a file that is packed in memory; else no descriptor
  explicit Implementation(render::Dataset first, Descriptor memory = Descriptor(), inside::Origin origin = {});

  /// The dataset with this field; it is loaded at its first use. Empty: that of Dataset::field().
  /// A stop request also ends the wait for another caller.
  render::Dataset of(std::string_view field = {}, const rhoray::Watch& watch = {}) const;

  /// Calls act(const render::Dataset&) with each field that is loaded.
  template <class Act>
  void for_each_loaded(const Act& act) const {
    std::vector<render::Dataset> all{first_};
    {
      const StoppableLock lock(guard_, {});
      for (const auto& [field, dataset] : loaded_) all.push_back(dataset);
    }
    for (const render::Dataset& dataset : all) act(dataset);
  }

  const render::Dataset& first() const { return first_; }
  const std::vector<FieldInfo>& fields() const { return fields_; }
  const FieldInfo& field(std::string_view name) const;
  const Descriptor& memory() const { return memory_; }
  bool is_in_memory() const { return origin_.is_in_memory || memory_.number() >= 0; }
  /// Refuses arrays of the caller, which are in no file.
  void require_whole_file(std::string_view call) const;
  const std::optional<inside::MeshPart>& part() const { return origin_.part; }
  std::uint64_t id() const { return id_; }

 private:
  render::Dataset first_;
  Descriptor memory_;
  inside::Origin origin_;
  std::vector<FieldInfo> fields_;
  std::uint64_t id_;
  mutable StoppableMutex guard_;
  mutable std::map<std::string, render::Dataset, std::less<>> loaded_;  ///< by field
};

class Texture::Implementation {
 public:
  explicit Implementation(render::Texture texture) : of(std::move(texture)) {}
  render::Texture of;
};

namespace inside {

/// Dataset::open for calls that are guarded already.
Dataset opened(const std::filesystem::path& path, const rhoray::Watch& watch);

/// A handle of what a room has loaded.
Dataset handle_of(const render::Dataset& dataset, Origin origin = {});

}  // namespace inside

}  // namespace rhoray::v0_1
