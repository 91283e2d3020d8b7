#include <cstring>
#include <string>
#include <vector>

#include "formats/base/error.h"
#include "preprocess/import/readers.h"
#include "preprocess/import/reading/families.h"
#include "preprocess/import/reading/numbers.h"
#include "preprocess/import/vtk/grid_surface.h"
#include "preprocess/import/worker_arguments.h"
#include "preprocess/process/child_process.h"
#include "preprocess/process/counts.h"
#include "preprocess/process/foreign_file.h"
#include "preprocess/process/messages.h"
#include "preprocess/subdivide.h"

namespace {

using namespace rhoray;
using namespace rhoray::preprocess;

template <class T>
bool same_bytes(const Array<T>& a, const Array<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

/// Writes, then reads the file back from disk, so that a full disk or a failing writer is noticed.
NeutralMesh write_and_read_back(const NeutralMesh& mesh, const std::string& path) {
  write_vtu(mesh, path);
  NeutralMesh read = [&] {
    try {
      return subdivide(read_vtu(path), {});  // the file may have no name yet
    } catch (const Error& error) {           // the file is not the user's input
      throw Error(ErrorCode::resource, concat("what was written cannot be read back: ", error.what()));
    }
  }();
  if (!same_bytes(read.points, mesh.points) || !same_bytes(read.cells, mesh.cells))
    throw Error(ErrorCode::resource, path + ": found another mesh when reading it back; expected what was written");
  return read;
}

double isovalue_of(const std::string& text) {
  const std::optional<double> value = parse_number<double>(text);
  if (!value) throw Error(ErrorCode::usage, concat("isovalue: found '", text, "'; expected a number"));
  return *value;
}

template <class Read>
Read with_sources(Read read) {
  read.sources = noted_sources();
  return read;
}

void write_stl(const std::vector<std::string>& arguments, int output) {
  const StlCounts triangles = write_grid_surface(arguments[1], arguments[2], isovalue_of(arguments[3]), arguments[4]);
  hand_over_counts({triangles.written, triangles.vanished}, output);
}

void act(const std::vector<std::string>& arguments, int input, int output) {
  const std::string verb = arguments.empty() ? "" : arguments[0];
  if ((verb == "volume" || verb == "colors") && arguments.size() >= 4)
    send(with_sources(read_volume(arguments[1], volume_request(arguments))), output);
  else if (verb == "cells" && arguments.size() == 3)
    send(with_sources(read_cells(arguments[1], {.time = arguments[2]})), output);
  else if (verb == "surface" && arguments.size() == 3)
    send(with_sources(read_surface(arguments[1], arguments[2])), output);
  else if (verb == "write-vtu" && arguments.size() == 2 && input >= 0)
    send(write_and_read_back(receive_mesh(formats::PackedFile::from_descriptor(input, "input")), arguments[1]), output);
  else if (verb == "write-stl" && arguments.size() == 5)
    write_stl(arguments, output);
  else
    throw Error(ErrorCode::usage,
                "found arguments that no verb has; expected those of preprocess/process/worker_names.h");
}

}  // namespace

#ifdef __SANITIZE_ADDRESS__
// VTK and Teem leak memory when they refuse a damaged file; the process ends anyway.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libvtk\nleak:libteem\n";
}
#endif

int main(int count, char** words) {
  const std::vector<std::string> arguments(words + 1, words + count);
  return worker_main([&](int input, int output) { act(arguments, input, output); });
}
