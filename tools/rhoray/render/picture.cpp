#include "tools/rhoray/render/picture.h"

#include <unistd.h>

#include <algorithm>
#include <utility>

#include "formats/base/bytes.h"
#include "formats/base/error.h"
#include "formats/base/number_text.h"
#include "render/document.h"
#include "render/scene_words.h"
#include "tools/analysis/measure.h"
#include "tools/analysis/pick.h"
#include "tools/pictures/annotations.h"
#include "tools/pictures/pictures.h"
#include "tools/rhoray/accuracy_options.h"
#include "tools/rhoray/cli/version.h"
#include "tools/rhoray/damage.h"
#include "tools/rhoray/render/picture_options.h"
#include "tools/rhoray/render/reproduce.h"

namespace rhoray::tools {

namespace {

/// @param antialiases  depths and normals are compared
std::uint64_t framebuffer_bytes(const render::PictureSize& size, render::ChannelSet channels, bool antialiases) {
  if (antialiases) channels |= {.depth = true, .normal = true};
  const std::uint64_t pixel =
      4 * sizeof(float) + (channels.depth ? sizeof(float) : 0) + (channels.normal ? 3 * sizeof(float) : 0) +
      (channels.cell ? sizeof(std::uint64_t) : 0) + (channels.value ? sizeof(double) : 0) +
      (channels.error ? sizeof(float) : 0) + (antialiases ? 2 : 0) +
      sizeof(std::uint32_t) * (std::uint64_t{channels.roots} + channels.iterations + channels.cost);
  return pixel * static_cast<std::uint64_t>(size.width) * static_cast<std::uint64_t>(size.height);
}

std::uint64_t memory_of_machine() {
  const long pages = ::sysconf(_SC_PHYS_PAGES), page_bytes = ::sysconf(_SC_PAGESIZE);
  return static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page_bytes);
}

void require_memory(const RenderCommand& command, const render::ResolvedScene& plan, const render::PictureSize& sheet) {
  const std::uint64_t needed =
      framebuffer_bytes({plan.frame.width, plan.frame.height}, plan.frame.channels, plan.frame.antialiasing > 1) +
      framebuffer_bytes(sheet, {}, false);
  const std::uint64_t asked = command.common.memory.bytes;
  const std::uint64_t limit = asked != 0 ? asked : memory_of_machine();
  if (needed > limit)
    throw Error(ErrorCode::resource, concat("--size: the picture needs ", bytes_text(needed), " of memory; ",
                                            asked != 0 ? "--memory allows " : "this machine has ", bytes_text(limit)));
}

/// Refuses with the damaged blocks' names.
void refuse_damage(const formats::PackedFile& file, const std::vector<formats::DamagedBlock>& blocks) {
  if (blocks.empty()) return;
  constexpr std::size_t shown_count = 4;
  std::string fact = packed_name(file) + ":";
  for (std::size_t i = 0; i < std::min(shown_count, blocks.size()); ++i)
    fact += concat(i == 0 ? " " : "; ", damage_text(file, blocks[i]));
  if (blocks.size() > shown_count) fact += concat("; and ", blocks.size() - shown_count, " more");
  throw Error(ErrorCode::invalid, fact, concat("no picture was written; ", damage_hint(file)));
}

std::vector<Json> take_picks(const std::vector<PixelPlace>& pixels, const render::ResolvedScene& plan,
                             const render::Framebuffer& framebuffer) {
  std::vector<Json> picks;
  for (const PixelPlace& pixel : pixels) picks.push_back(picked(plan, framebuffer, pixel));
  return picks;
}

/// Checks all files of a scene and refuses the first damaged one.
void check_files(const render::ResolvedScene& plan) {
  for (const render::Dataset& dataset : plan.datasets) refuse_damage(dataset.file(), dataset.file().damaged_blocks(1));
  for (const render::Texture& texture : plan.textures) refuse_damage(texture.file(), texture.file().damaged_blocks(1));
}

void require_writable(const RenderCommand& command, const std::filesystem::path& output,
                      const render::ResolvedScene& plan, const DataAccess& access) {
  for (const std::filesystem::path& input : command.inputs) require_writable(command.common, output, input);
  for (const auto* data : {&plan.data, &plan.texture_data})
    for (const render::DataSpec& each : *data) require_writable(command.common, output, each.file);
  require_not_read(output, access);
}

}  // namespace

Checks::Checks(const RenderCommand& command, const render::ResolvedScene& plan) {
  if (!command.no_verify) running_ = std::async(std::launch::async, [&plan] { check_files(plan); });
}

double Checks::wait() {
  const Stopwatch waiting;
  if (running_.valid()) running_.get();
  return waiting.seconds();
}

void settle_annotations(const render::SceneSpec& asked, const std::filesystem::path& output,
                        render::ResolvedScene& plan) {
  const bool is_data = output.extension() == ".exr";  // its pixels
  for (render::LayerOrigin& origin : plan.origins)
    if (is_data && !asked.layers[origin.spec].feature_edges)
      origin.feature_edges_deg = render::no_feature_edges, origin.lines.reset();
  if (!plan.has_default_annotations) return;
  const auto leave_out = [&] {
    plan.annotations = asked.annotations;
    plan.has_default_annotations = false;
  };
  if (is_data) return leave_out();
  if (can_annotate()) return;
  leave_out();
  plan.notes.push_back(
      "no colour bar, legend or box: they need the module rhoray-pictures.so and the font DejaVu Sans");
}

bool keeps_alpha(const render::SceneSpec& scene_spec) {
  return scene_spec.image.background && !scene_spec.image.background->color;
}

void require_picture(const RenderCommand& command, const std::filesystem::path& output,
                     const render::ResolvedScene& plan, const DataAccess& access, const render::PictureSize& sheet) {
  if (output != "-") require_writable(command, output, plan, access);
  require_memory(command, plan, sheet);
  if (has_texts(plan)) {
    require_pictures_module();
    find_font(known_fonts());
  }
  if (command.self_check.pixels > 0) require_checkable(plan);
}

void prove_ranges(const RenderCommand& command, Drawn& drawn, const Progress& progress) {
  for (const render::Dataset& dataset : drawn.plan.datasets)
    drawn.range_proof += dataset.prove_ranges(command.common.threads, {{}, progress});
}

render::Framebuffer trace(const RenderCommand& command, render::RenderContext& memory, Drawn& drawn,
                          const Progress& progress) {
  render::ResolvedScene& plan = drawn.plan;
  plan.frame.threads = command.common.threads;
  plan.frame.time_phases = command.statistics;
  // Picks and heat maps need channels that are not kept in the picture.
  const render::ChannelSet kept = plan.frame.channels;
  if (!command.picks.empty()) plan.frame.channels |= channels_of_picks(plan.scene);
  if (plan.page) plan.frame.channels |= render::channel_of(*plan.page);
  plan.frame.channels |= channels_of_annotations(plan);
  if (command.self_check.pixels > 0) plan.frame.channels |= channels_to_check(plan);

  render::Framebuffer framebuffer;
  const Stopwatch tracing;
  drawn.statistics = render::refine(plan.datasets, plan.scene, plan.frame,
                                    {.first_spacing = 1, .watch = {{}, progress}}, framebuffer, memory);
  drawn.stations.trace_s = tracing.seconds() - drawn.statistics.range_proof.wall_s;
  drawn.statistics.range_proof += std::exchange(drawn.range_proof, {});
  drawn.stations.prove_s = drawn.statistics.range_proof.wall_s;
  drawn.picks = take_picks(command.picks, plan, framebuffer);
  if (command.self_check.pixels > 0) {
    render::SelfCheckOptions check = command.self_check;
    check.watch.progress = progress;
    drawn.self_check = check_picture(plan, framebuffer, check, command.common.threads);
  }
  if (plan.page) drawn.heat = render::draw_heat_map(*plan.page, framebuffer);
  draw_annotations(plan, drawn.heat, framebuffer);
  framebuffer.keep(kept);
  plan.frame.channels = kept;
  return framebuffer;
}

std::vector<PictureText> texts_of_picture(const render::SceneSpec& scene, const std::filesystem::path& folder,
                                          const std::string& command, std::string_view machine) {
  return {{"Software", concat("rhoray ", version())},
          {"rhoray:command", command},
          {scene_text_name, render::scene_text(scene, folder)},
          {"rhoray:machine", std::string(machine)}};
}

void write(const RenderCommand& command, const render::Framebuffer& picture, const render::SceneSpec& scene,
           Drawn& drawn) {
  const Stopwatch writing;
  const std::filesystem::path folder = std::filesystem::absolute(drawn.output).parent_path();
  const std::vector<PictureText> texts = texts_of_picture(scene, folder, drawn.reproduce, drawn.statistics.machine);
  if (drawn.to_stdout) {
    const std::vector<std::byte> bytes = encode_picture(picture, texts, "picture.png");
    std::fwrite(bytes.data(), 1, bytes.size(), stdout);  // that it was taken is seen at the end (interrupt.h)
  } else {
    write_picture(picture, texts, drawn.output, command.common.force);
  }
  drawn.stations.write_s = writing.seconds();
}

void draw(const RenderCommand& command, render::RenderContext& memory, Checks& checks, Drawn& drawn,
          const Progress& progress) {
  const render::Framebuffer picture = trace(command, memory, drawn, progress);
  drawn.stations.wait_for_checks_s = checks.wait();
  drawn.reproduce = shell_line(reproducing_command(drawn.plan, drawn.output));
  write(command, picture, to_spec(drawn.plan), drawn);
}

}  // namespace rhoray::tools
