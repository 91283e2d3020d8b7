#include <span>

#include "preprocess/process/child_process.h"
#include "preprocess/process/messages.h"
#include "preprocess/workers/repair/mend.h"
#include "preprocess/workers/repair/report.h"

/// Reads a surface, mends it, hands it back with the report as its last note.
int main(int argc, char** argv) {
  using namespace rhoray;
  return preprocess::worker_main([&](int input, int output) {
    const auto options = preprocess::repair::options_from(std::span<const char* const>(argv + 1, argv + argc));
    auto repaired = preprocess::repair::mend(
        preprocess::receive_surface(formats::PackedFile::from_descriptor(input, "handed-over surface")), options);
    repaired.surface.notes.push_back(preprocess::repair::text_of(repaired.report));
    preprocess::send(repaired.surface, output);
  });
}
