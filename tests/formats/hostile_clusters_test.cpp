#include <gtest/gtest.h>

#include <string>

#include "formats/tet_mesh.h"
#include "tests/support/expect_error.h"
#include "tests/support/longer_table.h"
#include "tests/support/memory_file.h"

// Files with correct checksums whose tables are larger than readers can hold for a cluster. The
// renderer once wrote past the end of arrays of 256 on its stack.
namespace rhoray::formats {
namespace {

void open_mesh(const std::string& bytes) {
  const tests::MemoryFile memory(bytes);
  TetMesh(PackedFile::from_descriptor(memory.descriptor(), "f.rho"));
}

TEST(HostileClusters, tables_of_more_than_256_vertices_are_refused) {
  // The last table has 7 vertices. 400 more are 25 times 64 bytes, so no byte of padding changes.
  tests::expect_error(ErrorCode::invalid,
                      "f.rho, array 'cluster.offsets', cluster 2: found a table of 407 vertices; expected at most 256",
                      [] { open_mesh(tests::with_longer_table(RHORAY_RELEASED_FILES, 400)); });
  tests::expect_error(ErrorCode::invalid, "found a table of 263 vertices",
                      [] { open_mesh(tests::with_longer_table(RHORAY_RELEASED_FILES, 256)); });
  EXPECT_NO_THROW(open_mesh(tests::with_longer_table(RHORAY_RELEASED_FILES, 240)))
      << "247 vertices fit: useless ones are for verify --deep to find";
}

}  // namespace
}  // namespace rhoray::formats
