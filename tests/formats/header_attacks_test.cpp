#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "formats/brick_grid.h"
#include "formats/tet_mesh.h"
#include "tests/support/expect_error.h"
#include "tests/support/memory_file.h"
#include "tests/support/packed_samples.h"
#include "tests/support/resealed.h"

// Files with correct checksums but wrong text.
namespace rhoray::formats {
namespace {

using tests::expect_error;
using tests::MemoryFile;
using tests::with_header_change;

std::string grid_bytes() {
  const MemoryFile memory;
  const auto grid = tests::sample_grid<std::uint8_t>(
      BrickLayout::bricked({5, 4, 3}), [](std::int64_t i, std::int64_t j, std::int64_t k) { return i * j + k; });
  PackedFileWriter writer(memory.descriptor(), describe(grid.description), grid_arrays(grid.description));
  grid.write_into(writer).commit();
  return memory.content();
}

std::string mesh_bytes(bool has_clusters = false, const std::vector<std::uint64_t>& boundary = {}) {
  const MemoryFile memory;
  auto mesh = tests::sample_tets(
      1, {{"f", [](const Vec3& p) { return p.x; }}, {"g", [](const Vec3& p) { return p.y; }}}, {2, 2, 1});
  if (has_clusters) mesh = clustered(mesh, 4);
  mesh.boundary = boundary;
  mesh.description.boundary_face_count = boundary.size();
  PackedFileWriter writer(memory.descriptor(), describe(mesh.description), tet_mesh_arrays(mesh.description));
  mesh.write_into(writer).commit();
  return memory.content();
}

void open(const std::string& bytes) {
  const MemoryFile memory(bytes);
  PackedFile::from_descriptor(memory.descriptor(), "f.rho");
}
void open_grid(const std::string& bytes) {
  const MemoryFile memory(bytes);
  BrickGrid(PackedFile::from_descriptor(memory.descriptor(), "f.rho"));
}
void open_mesh(const std::string& bytes) {
  const MemoryFile memory(bytes);
  TetMesh(PackedFile::from_descriptor(memory.descriptor(), "f.rho"));
}

/// One change of the text, and the expected message.
struct Attack {
  std::string from, to, words;
  ErrorCode error_code = ErrorCode::invalid;
};

TEST(ResealedFile, unchanged_content_gives_the_writers_bytes) {
  // Also shows that the helper's independent code and the writer agree on SPEC.md.
  EXPECT_EQ(tests::seal_again(tests::open_envelope(grid_bytes())), grid_bytes());
  EXPECT_EQ(tests::seal_again(tests::open_envelope(mesh_bytes())), mesh_bytes());
}

TEST(ResealedFile, headers_that_break_the_grammar_are_refused_at_their_place) {
  const std::string file = grid_bytes();
  const std::string first = R"("macro.1":{"dtype":"U8","shape":[1,2,2,2],"data_offsets":[0,8]})";
  const std::string ten_nests = R"("macro.1":[[[[[[[[[[1]]]]]]]]]])";
  for (const Attack& attack : std::vector<Attack>{
           {first, first + "," + first, "array 'macro.1' twice"},
           {first, R"("macro.1":{"dtype":"U8","dtype":"U8","shape":[8],"data_offsets":[0,8]})",
            "dtype: found the key twice"},
           {first, R"("macro.1":{"dtype":"U8","shape":[8],"shape":[8],"data_offsets":[0,8]})",
            "shape: found the key twice"},
           {first, R"("macro.1":{"dtype":"U8","shape":[8],"data_offsets":[0,8],"more":1})",
            "more: found a key of that name"},
           {first, R"("macro.1":{"dtype":"U8","shape":[8]})", "array 'macro.1': found an incomplete entry"},
           {first, R"("macro.1":{"shape":[8],"data_offsets":[0,8]})", "array 'macro.1': found an incomplete entry"},
           {first, R"("macro.1":{})", "array 'macro.1': found an incomplete entry"},
           {first, R"("macro.1":7)", "found 7; expected an object"},
           {first, R"("macro.1":[1,2])", "found a list; expected an object"},
           {first, R"("macro.1":null)", "found null; expected an object"},
           {first, R"("":{"dtype":"U8","shape":[8],"data_offsets":[0,8]})", "a name of 0 bytes"},
           {first, "\"" + std::string(257, 'n') + R"(":{"dtype":"U8","shape":[8],"data_offsets":[0,8]})",
            "a name of 257 bytes"},
           {first, R"("a\u001b[31m":{"dtype":"U8","shape":[8],"data_offsets":[0,8]})", "without control characters"},
           {first, ten_nests, "found a list; expected an object"},
           {R"("shape":[1,2,2,2])", R"("shape":[1,[2],2,2])", "shape: found a list; expected unsigned integers"},
           {R"("shape":[1,2,2,2])", R"("shape":[1,{"a":2},2,2])", "shape: found an object"},
           {R"("shape":[1,2,2,2])", R"("shape":{"a":8})", "shape: found an object"},
           {R"("shape":[1,2,2,2])", R"("shape":8)", "shape: found 8; expected a list"},
           {R"("shape":[1,2,2,2])", R"("shape":[1,-2,2,2])", "found -2; expected unsigned integers"},
           {R"("shape":[1,2,2,2])", R"("shape":[1,2.0,2,2])", "found 2.0; expected unsigned integers"},
           {R"("shape":[1,2,2,2])", R"("shape":[1,2e0,2,2])", "found 2e0; expected unsigned integers"},
           {R"("shape":[1,2,2,2])", R"("shape":[1,18446744073709551616,2,2])", "found 18446744073709551616"},
           {R"("shape":[1,2,2,2])", R"("shape":[1,"2",2,2])", "found \"2\"; expected unsigned integers"},
           {R"("shape":[1,2,2,2])", R"("shape":[1,true,2,2])", "found true; expected unsigned integers"},
           {R"("shape":[1,2,2,2])", R"("shape":[1,1,1,1,1,2,2,2,1])", "found one number more; expected at most 8"},
           {R"("data_offsets":[0,8])", R"("data_offsets":[0,8,9])", "found one number more; expected at most 2"},
           {R"("data_offsets":[0,8])", R"("data_offsets":[8])", "an incomplete entry"},
           {R"("version")", R"("kind":"grid","version")", "__metadata__: found 'kind' twice"},
           {R"("version":"1.0")", R"("version":1)", "__metadata__, version: found 1; expected a text"},
           {R"("version":"1.0")", R"("version":["1.0"])", "__metadata__, version: found a list"},
           {R"("version":"1.0",)", "", "__metadata__, version: found nothing"},
           {R"("kind":"grid",)", "", "__metadata__, kind: found nothing"},
           {R"(,"requires":"")", "", "__metadata__, requires: found nothing"},
           {R"("_sum")", R"("_sun")", "expected _sum and _seal"},
           {R"("_seal")", R"("_zeal")", "header"},
           {"]}}", "]}", "text that is not JSON"},
           {R"("dtype":"U8")", R"("dtype":"U8)", "text that is not JSON"},
           {R"("kind":"grid")",
            "\"kind\":\"gr\xff"
            "d\"",
            "text that is not JSON"},
           {"]}}", "]}}}", "text that is not JSON"},
           {"]}}", "]}} 1", "text that is not JSON"},
           {"]}}", std::string("]}}\0", 4), "a control character"},
           {"]}}", "]}}\n", "a control character"},
       })
    expect_error(attack.error_code, attack.words, [&] { open(with_header_change(file, attack.from, attack.to)); });
}

TEST(ResealedFile, arrays_that_overlap_leave_gaps_or_lie_outside_are_refused_by_name) {
  const std::string file = grid_bytes();
  const std::string one = R"("shape":[1,2,2,2],"data_offsets":[0,8])";
  for (const Attack& attack : std::vector<Attack>{
           {one, R"("shape":[9],"data_offsets":[0,9])", "found its start at 8; expected it at 9"},
           {one, R"("shape":[7],"data_offsets":[0,7])", "found its start at 8; expected it at 7"},
           {one, R"("shape":[7],"data_offsets":[1,8])", "array 'macro.1': found its start at 1; expected it at 0"},
           {one, R"("shape":[1,2,2,2],"data_offsets":[8,0])", "array 'macro.1': found data_offsets [8,0]"},
           {one, R"("shape":[1,2,2,3],"data_offsets":[0,8])",
            "array 'macro.1': found 8 bytes; expected 12 for its shape"},
           {one, R"("shape":[4294967296,4294967296,4294967296],"data_offsets":[0,8])",
            "a shape whose size fits 64 bits"},
           {one, R"("shape":[9223372036854775808,2],"data_offsets":[0,8])", "a shape whose size fits 64 bits"},
           {one, R"("shape":[9223372036854775808],"data_offsets":[0,9223372036854775808])", "within the data area"},
           {one, R"("shape":[18446744073709551615],"data_offsets":[0,18446744073709551615])", "within the data area"},
           {"_pad.0", "pad.0", "array 'pad.0': found its start at 8; expected a multiple of 64"},
           {R"("_sum":{"dtype":"U64","shape":[1])", R"("_sum":{"dtype":"U8","shape":[8])", "array '_sum'"},
           {R"("_seal":{"dtype":"U8","shape":[64])", R"("_seal":{"dtype":"U64","shape":[8])", "array '_seal'"},
       })
    expect_error(attack.error_code, attack.words, [&] { open(with_header_change(file, attack.from, attack.to)); });
}

TEST(ResealedFile, the_array_that_ends_behind_the_data_area_is_named) {
  const std::string file = grid_bytes();
  const auto [type, begin, end] = tests::place_of(tests::open_envelope(file), "_seal");
  const auto entry = [&, begin = begin](std::uint64_t bytes) {
    return concat("\"shape\":[", bytes, "],\"data_offsets\":[", begin, ",", begin + bytes, "]");
  };
  expect_error(ErrorCode::invalid, concat("array '_seal': found its end at ", end + 1),
               [&] { open(with_header_change(file, entry(64), entry(65))); });
}

TEST(ResealedFile, what_a_newer_program_wrote_is_refused_as_unsupported) {
  const std::string file = grid_bytes();
  expect_error(ErrorCode::unsupported, "version: found 2.0; expected 1.x",
               [&] { open(with_header_change(file, R"("version":"1.0")", R"("version":"2.0")")); });
  expect_error(ErrorCode::unsupported, "found the feature 'wavelets'",
               [&] { open(with_header_change(file, R"("requires":"")", R"("requires":"wavelets,time")")); });
  expect_error(ErrorCode::unsupported, "found dtype 'F16'",
               [&] { open(with_header_change(file, R"("dtype":"U8")", R"("dtype":"F16")")); });
  for (const char* version : {"1", "1.", ".0", "1.0.0", "one", "-1.0", "1.99999", ""})
    expect_error(ErrorCode::invalid, "two numbers such as 1.0", [&] {
      open(with_header_change(file, R"("version":"1.0")", concat(R"("version":")", version, "\"")));
    });
}

TEST(ResealedFile, a_newer_minor_version_with_more_keys_and_arrays_is_read) {
  std::string file = with_header_change(grid_bytes(), R"("version":"1.0")", R"("version":"1.7","note":"hello")");
  for (const char* name : {"_new", "new"})
    file = with_header_change(file, "\"macro.1\"",
                              concat("\"", name, R"(":{"dtype":"I64","shape":[0],"data_offsets":[0,0]},"macro.1")"));
  file = with_header_change(file, R"({\"sample_count\")", R"({\"mood\":[{\"a\":1}],\"sample_count\")");
  const MemoryFile memory(file);
  const BrickGrid grid(PackedFile::from_descriptor(memory.descriptor(), "f.rho"));
  EXPECT_EQ(grid.file().version(), "1.7");
  EXPECT_EQ(grid.file().arrays().size(), 4U) << "names that start with _ are the envelope's own";
}

TEST(ResealedFile, header_lengths_out_of_bounds_are_refused) {
  const std::string file = grid_bytes();
  for (const std::uint64_t length :
       {std::uint64_t{0}, std::uint64_t{4087}, std::uint64_t{4089}, std::uint64_t{4096}, std::uint64_t{1} << 20,
        std::uint64_t{1} << 40, ~std::uint64_t{0}, ~std::uint64_t{7}, std::uint64_t{4096 * 5 - 8}}) {
    std::string changed = file;
    std::memcpy(changed.data(), &length, sizeof length);
    expect_error(ErrorCode::invalid, concat("byte 0: found a header length of ", length), [&] { open(changed); });
  }
}

/// A file with a changed value in its seal and the correct checksum of the seal.
std::string with_seal_change(std::string file, std::size_t at, std::uint64_t value) {
  const std::size_t seal = file.size() - 64;
  std::memcpy(file.data() + seal + at, &value, sizeof value);
  const std::uint64_t sum = XXH3_64bits(file.data() + seal, 56);
  std::memcpy(file.data() + seal + 56, &sum, sizeof sum);
  return file;
}

TEST(ResealedFile, seals_that_speak_of_another_file_are_refused) {
  const std::string file = grid_bytes();
  const std::string size = concat(file.size());
  EXPECT_EQ(with_seal_change(file, 8, file.size()), file);
  expect_error(ErrorCode::invalid, concat("found a file of ", size, " bytes; expected 17"),
               [&] { open(with_seal_change(file, 8, 17)); });
  expect_error(ErrorCode::invalid, concat("expected ", size, " bytes"),
               [&] { open(file + std::string(4096, 'x') + file.substr(file.size() - 64)); });
  expect_error(ErrorCode::invalid, "found blocks of 4096 bytes; expected 65536",
               [&] { open(with_seal_change(file, 16, 4096)); });
  expect_error(ErrorCode::invalid, "header: found bytes that do not match",
               [&] { open(with_seal_change(file, 24, 1)); });
  expect_error(ErrorCode::invalid, "array '_sum': found bytes that do not match",
               [&] { open(with_seal_change(file, 48, 1)); });
}

TEST(ResealedFile, more_arrays_than_allowed_are_refused) {
  tests::Envelope parts = tests::open_envelope(grid_bytes());
  std::string many;
  for (int i = 0; i < 4096; ++i) many += concat("\"a", i, R"(":{"dtype":"U8","shape":[0],"data_offsets":[0,0]},)");
  parts.json.insert(parts.json.find("\"macro.1\""), many);
  expect_error(ErrorCode::invalid, "found one array more; expected at most 4096",
               [&] { open(tests::seal_again(parts)); });
}

TEST(ResealedFile, a_header_above_its_limit_is_refused) {
  tests::Envelope parts = tests::open_envelope(grid_bytes());
  parts.json.insert(parts.json.find("\"version\""), concat("\"long\":\"", std::string(1 << 20, 'x'), "\","));
  expect_error(ErrorCode::invalid, "byte 0: found a header length", [&] { open(tests::seal_again(parts)); });
}

TEST(ResealedFile, details_of_a_grid_that_miss_a_key_or_hold_another_type_are_refused_by_name) {
  const std::string file = grid_bytes();
  for (const char* key : {"sample_count", "brick_edge", "superbrick_edge", "world_from_grid", "x_axis", "y_axis",
                          "z_axis",       "origin",     "length_unit",     "field",           "name",   "unit",
                          "type",         "range",      "no_data_count",   "histogram",       "macro",  "factor",
                          "level_count",  "provenance", "source_name",     "source_checksum", "command"}) {
    const std::string quoted = concat("\\\"", key, "\\\":");
    expect_error(ErrorCode::invalid, concat(key, ": found nothing"),
                 [&] { open_grid(with_header_change(file, quoted, concat("\\\"_", key, "\\\":"))); });
    expect_error(ErrorCode::invalid, concat(key, ": found true"),
                 [&] { open_grid(with_header_change(file, quoted, concat(quoted, "true,\\\"old_", key, "\\\":"))); });
    expect_error(ErrorCode::invalid, concat("found the key \"", key, "\" twice"),
                 [&] { open_grid(with_header_change(file, quoted, concat(quoted, "0,", quoted))); });
  }
}

TEST(ResealedFile, details_of_a_grid_out_of_their_limits_are_refused_by_name) {
  const std::string file = grid_bytes();
  for (const Attack& attack : std::vector<Attack>{
           {R"(sample_count\":[5,4,3])", R"(sample_count\":[1,4,3])",
            "sample_count: found [1,4,3]; expected three integers from 2"},
           {R"(sample_count\":[5,4,3])", R"(sample_count\":[5,4])", "sample_count: found [5,4]"},
           {R"(sample_count\":[5,4,3])", R"(sample_count\":[5,4,-3])", "sample_count: found [5,4,-3]"},
           {R"(sample_count\":[5,4,3])", R"(sample_count\":[5,4,3.0])", "sample_count: found [5,4,3.0]"},
           {R"(sample_count\":[5,4,3])", R"(sample_count\":[5,4,4294967296])", "sample_count"},
           {R"(sample_count\":[5,4,3])", R"(sample_count\":[1048576,1048576,1048576])", "array 'samples'"},
           {R"(sample_count\":[5,4,3])", R"(sample_count\":[5,4,9])", "array 'samples': found U8 ["},
           {R"(sample_count\":[5,4,3])", R"(sample_count\":[3,4,3])", "array 'macro.1': found U8"},
           {R"(brick_edge\":4)", R"(brick_edge\":0)", "brick_edge: found 0"},
           {R"(brick_edge\":4)", R"(brick_edge\":4000000000)", "brick_edge: found 4000000000"},
           {R"(superbrick_edge\":[)", R"(superbrick_edge\":[0,1,1],\"s\":[)", "superbrick_edge: found [0,1,1]"},
           {R"(superbrick_edge\":[)", R"(superbrick_edge\":[64,64,64],\"s\":[)", "array 'samples'"},
           {R"(x_axis\":[1.0,0.0,0.0])", R"(x_axis\":[0.0,0.0,0.0])", "expected axes that span a volume"},
           {R"(x_axis\":[1.0,0.0,0.0])", R"(x_axis\":[1e-320,0.0,0.0])", "expected axes that span a volume"},
           {R"(x_axis\":[1.0,0.0,0.0])", R"(x_axis\":[1e999,0.0,0.0])", "details: found a number out of range"},
           {R"(x_axis\":[1.0,0.0,0.0])", R"(x_axis\":[\"1\",0.0,0.0])", "x_axis: found [\"1\",0.0,0.0]"},
           {R"(brick_edge\":4)", R"(brick_edge\":4,\"space\":\"LAS\")", "space: found \"LAS\"; expected RAS or LPS"},
           {R"(brick_edge\":4)", R"(brick_edge\":4,\"space\":7)", "space: found 7"},
           {R"(type\":\"U8\")", R"(type\":\"U7\")", "details.field.type: found \"U7\""},
           {R"(type\":\"U8\")", R"(type\":\"U16\")", "array 'samples': found U8"},
           {R"(name\":\"density\")", R"(name\":\"\")", "details.field.name: found \"\"; expected a name"},
           {R"(range\":[)", R"(range\":[3.0,2.0],\"r\":[)", "range: found [3.0,2.0]"},
           {R"(range\":[)", R"(mean_gradient\":[],\"range\":[)", "isosurface_area: found nothing"},
           {R"(range\":[)", R"(isosurface_area\":[1.0],\"mean_gradient\":[1.0],\"range\":[)",
            "isosurface_area: found [1.0]; expected a list of 16 finite numbers of at least 0"},
           {R"(histogram\":[)", R"(histogram\":[24],\"isosurface_area\":[-1.0],\"mean_gradient\":[1.0],\"h\":[)",
            "isosurface_area: found [-1.0]; expected a list of 1 finite numbers of at least 0"},
           {R"(histogram\":[)", R"(histogram\":[24],\"isosurface_area\":[1.0],\"mean_gradient\":[\"1\"],\"h\":[)",
            "mean_gradient: found [\"1\"]"},
           {R"(histogram\":[)", R"(histogram\":[24],\"isosurface_area\":7,\"mean_gradient\":[1.0],\"h\":[)",
            "isosurface_area: found 7"},
           {R"(factor\":2)", R"(factor\":1)", "details.macro.factor: found 1"},
           {R"(factor\":2)", R"(factor\":3)", "array 'macro.1'"},
           {R"(level_count\":2)", R"(level_count\":0)", "details.macro.level_count: found 0"},
           {R"(level_count\":2)", R"(level_count\":3)", "array 'macro.3': found nothing"},
           {R"(level_count\":2)", R"(level_count\":1000000000)", "details.macro.level_count"},
           {R"("details":"{)", R"("details":"[)", "text that is not JSON"},
           {R"("details":"{)", R"("details":"7{)", "text that is not JSON"},
           {R"("details":"{)", R"("details":"{\"n\":[[[[[[[[[[[[1]]]]]]]]]]]],)", "details: found deeper nesting"},
           {R"("details":"{)", R"("details":"{}\u0000{)", "details: found a zero byte"},
       })
    expect_error(attack.error_code, attack.words, [&] { open_grid(with_header_change(file, attack.from, attack.to)); });
}

TEST(ResealedFile, names_of_labels_that_no_writer_makes_are_refused_by_name) {
  const std::string grid = grid_bytes(), mesh = mesh_bytes();
  const auto named = [](const std::string& file, const std::string& names) {
    return with_header_change(file, R"(range\":[)", concat(R"(label_names\":)", names, R"(,\"range\":[)"));
  };
  EXPECT_NO_THROW(open_grid(named(grid, R"({\"-2147483648\":\"b\u00f6se\",\"0\":\"\\\"\"})")));
  EXPECT_NO_THROW(open_mesh(named(mesh, R"({\"2147483647\":\"liver\"})")));
  const std::string wide(128, 'w');
  EXPECT_NO_THROW(open_grid(named(grid, concat(R"({\"1\":\")", wide, R"(\"})"))));
  std::string many = "{";
  for (int label = 0; label <= 1024; ++label) many += concat(label == 0 ? "" : ",", R"(\")", label, R"(\":\"a\")");
  for (const auto& [names, words] : std::vector<std::pair<std::string, std::string>>{
           {"7", "label_names: found 7; expected an object of at most 1024 names"},
           {R"([\"liver\"])", "label_names: found [\"liver\"]; expected an object"},
           {"null", "label_names: found null"},
           {many + "}", "label_names: found 1025 names; expected an object of at most 1024 names"},
           {R"({\"liver\":\"1\"})", "label_names: found the key \"liver\"; expected an integer of 32 bits"},
           {R"({\"1.5\":\"a\"})", "label_names: found the key \"1.5\""},
           {R"({\"01\":\"a\"})", "label_names: found the key \"01\""},
           {R"({\"+1\":\"a\"})", "label_names: found the key \"+1\""},
           {R"({\"-0\":\"a\"})", "label_names: found the key \"-0\""},
           {R"({\"\":\"a\"})", "label_names: found the key \"\""},
           {R"({\"2147483648\":\"a\"})", "label_names: found the key \"2147483648\""},
           {R"({\"1\":7})", "label_names.1: found 7; expected a name of 1 to 128 bytes of UTF-8"},
           {R"({\"1\":{}})", "label_names.1: found {}"},
           {R"({\"1\":\"\"})", "label_names.1: found \"\""},
           {concat(R"({\"1\":\"x)", wide, R"(\"})"), "label_names.1: found \"xwww"},
           {R"({\"1\":\"a\\u001b[31m\"})", R"(label_names.1: found "a\u001b[31m")"},
           {R"({\"1\":\"a\\u0085\"})", R"(label_names.1: found "a\u0085")"},
           {R"({\"1\":\"a\",\"1\":\"b\"})", "found the key \"1\" twice"}}) {
    expect_error(ErrorCode::invalid, words, [&, &n = names] { open_grid(named(grid, n)); });
    expect_error(ErrorCode::invalid, words, [&, &n = names] { open_mesh(named(mesh, n)); });
  }
}

TEST(ResealedFile, details_of_a_mesh_that_miss_a_key_or_hold_another_type_are_refused_by_name) {
  const std::string file = mesh_bytes();
  for (const char* key : {"origin",
                          "length_unit",
                          "point_count",
                          "cell_count",
                          "fields",
                          "name",
                          "unit",
                          "type",
                          "range",
                          "no_data_count",
                          "histogram",
                          "lattice",
                          "factor",
                          "level_count",
                          "leaf_count",
                          "low",
                          "leaf_size",
                          "leaf_item_count",
                          "flipped_cell_count",
                          "flat_cell_count",
                          "dropped_cell_count",
                          "unused_point_count",
                          "provenance",
                          "source_name",
                          "source_checksum",
                          "command"}) {
    const std::string quoted = concat("\\\"", key, "\\\":");
    expect_error(ErrorCode::invalid, concat(key, ": found nothing"),
                 [&] { open_mesh(with_header_change(file, quoted, concat("\\\"_", key, "\\\":"))); });
    expect_error(ErrorCode::invalid, concat(key, ": found true"),
                 [&] { open_mesh(with_header_change(file, quoted, concat(quoted, "true,\\\"old_", key, "\\\":"))); });
  }
}

TEST(ResealedFile, details_of_a_mesh_out_of_their_limits_are_refused_by_name) {
  const std::string file = mesh_bytes();
  for (const Attack& attack : std::vector<Attack>{
           {R"(leaf_count\":[2,2,1])", R"(leaf_count\":[1048576,1048576,1048576])", "array 'leaf.offsets'"},
           {R"(leaf_count\":[2,2,1])", R"(leaf_count\":[4294967296,4294967296,4294967296])",
            "leaf_count: found [4294967296"},
           {R"(leaf_count\":[2,2,1])", R"(leaf_count\":[2,2,0])", "leaf_count: found [2,2,0]"},
           {R"(leaf_count\":[2,2,1])", R"(leaf_count\":[4,1,1])", "array 'range.0.0'"},
           {R"(leaf_size\":[0.5,0.5,1.0])", R"(leaf_size\":[0.5,0.0,1.0])", "leaf_size: found [0.5,0.0,1.0]"},
           {R"(leaf_size\":[0.5,0.5,1.0])", R"(leaf_size\":[1.7e308,0.5,1.0])", "a lattice whose far corner is finite"},
           {R"(point_count\":8)", R"(point_count\":9)", "array 'points'"},
           {R"(point_count\":8)", R"(point_count\":0)", "point_count: found 0"},
           {R"(point_count\":8)", R"(point_count\":4294967296)", "point_count: found 4294967296"},
           {R"(cell_count\":6)", R"(cell_count\":6000000)", "array 'cells'"},
           {R"(leaf_item_count\":)", R"(leaf_item_count\":0,\"old\":)", "array 'leaf.items'"},
           {R"(leaf_item_count\":)", R"(leaf_item_count\":9223372036854775807,\"old\":)", "array 'leaf.items'"},
           {R"(dropped_cell_count\":0)", R"(dropped_cell_count\":1)", "array 'cell_ids': found nothing"},
           {R"(flat_cell_count\":)", R"(order\":\"curve\",\"flat_cell_count\":)", "array 'point_ranks': found nothing"},
           {R"(flat_cell_count\":)", R"(order\":\"deck\",\"flat_cell_count\":)",
            "order: found \"deck\"; expected \"curve\""},
           {R"(name\":\"g\")", R"(name\":\"f\")",
            "fields[1].name: found \"f\"; expected a name that no other field has"},
           {R"(type\":\"F32\")", R"(type\":\"U8\")", "fields[0].type: found \"U8\"; expected F32 or F64"},
           {R"(type\":\"F32\")", R"(type\":\"F64\")", "array 'field.0'"},
           {R"(fields\":[)", R"(fields\":[],\"old\":[)", "expected at least one field"},
           {R"(fields\":[)", R"(fields\":[7,)", "fields: found [7"},
       })
    expect_error(attack.error_code, attack.words, [&] { open_mesh(with_header_change(file, attack.from, attack.to)); });
}

TEST(ResealedFile, details_of_clusters_are_asked_for_and_held_to_their_limits) {
  const std::string file = mesh_bytes(true);
  for (const Attack& attack : std::vector<Attack>{
           {R"(requires":"cell-clusters")", R"(requires":"")", "leaf_item_count: found nothing"},
           {R"(clusters\":{)", R"(_clusters\":{)", "clusters: found nothing"},
           {R"(size\":4)", R"(_size\":4)", "clusters.size: found nothing"},
           {R"(size\":4)", R"(size\":0)", "clusters.size: found 0"},
           {R"(size\":4)", R"(size\":3)", "clusters.size: found 3; expected a power of two"},
           {R"(size\":4)", R"(size\":128)", "clusters.size: found 128"},
           {R"(size\":4)", R"(size\":2)", "array 'cluster.offsets'"},
           {R"(vertex_count\":)", R"(vertex_count\":9223372036854775807,\"old\":)", "array 'cluster.vertices'"},
           {R"(vertex_count\":)", R"(vertex_count\":0,\"old\":)", "clusters.vertex_count: found 0"},
           {R"(box_unit\":1.0)", R"(box_unit\":0.75)", "clusters.box_unit: found 0.75; expected a power of two"},
           {R"(box_unit\":1.0)", R"(box_unit\":0.0)", "clusters.box_unit: found 0.0; expected a power of two"},
           {R"(cell_count\":6)", R"(cell_count\":4294967295)", "array 'cluster.offsets'"},
       })
    expect_error(attack.error_code, attack.words, [&] { open_mesh(with_header_change(file, attack.from, attack.to)); });
  const std::string lists = mesh_bytes();
  expect_error(ErrorCode::invalid, "clusters: found nothing",
               [&] { open_mesh(with_header_change(lists, R"(requires":"")", R"(requires":"cell-clusters")")); });
}

TEST(ResealedFile, a_boundary_names_faces_of_cells_once) {
  const std::string file = mesh_bytes(false, {0, 5, 23});
  EXPECT_NO_THROW(open_mesh(file));
  for (const Attack& attack : std::vector<Attack>{
           {R"(boundary_face_count\":3)", R"(boundary_face_count\":0)", "boundary_face_count: found 0"},
           {R"(boundary_face_count\":3)", R"(boundary_face_count\":25)", "boundary_face_count: found 25"},
           {R"(boundary_face_count\":3)", R"(boundary_face_count\":4)", "array 'boundary'"}})
    expect_error(attack.error_code, attack.words, [&] { open_mesh(with_header_change(file, attack.from, attack.to)); });
  expect_error(ErrorCode::invalid, "array 'boundary', element 2: found 24; expected a number below 24, above 5", [&] {
    open_mesh(mesh_bytes(false, {0, 5, 24}));
  });
  expect_error(ErrorCode::invalid, "array 'boundary', element 1: found 5; expected a number below 24, above 5", [&] {
    open_mesh(mesh_bytes(true, {5, 5, 7}));
  });
  expect_error(ErrorCode::invalid, "array 'boundary', element 0",
               [&] { open_mesh(mesh_bytes(true, {std::numeric_limits<std::uint64_t>::max()})); });
}

}  // namespace
}  // namespace rhoray::formats
