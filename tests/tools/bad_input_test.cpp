#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/tools/workbench.h"

namespace rhoray::tests {
namespace {

using testing::HasSubstr;

struct Case {
  const char* name;
  std::vector<std::string> words;
  int exit_code;
  const char* fact;       ///< in the first line of stderr
  const char* hint = "";  ///< in the second line; empty: any
};

/// Makes all inputs of the cases: good ones, and ones with a single fault.
void make_inputs(const Workbench& bench) {
  bench.make_ball();
  bench.make_box();
  write_file(bench / "empty.rho", "");
  write_file(bench / "empty.nrrd", "");
  write_file(bench / "empty.vtu", "");
  write_file(bench / "empty.stl", "");
  write_file(bench / "notes.txt", "nothing to see");
  write_file(bench / "text.rho", std::string(10'000, 'x'));
  const std::string ball = read_file(bench / "ball.rho");
  write_file(bench / "truncated.rho", ball.substr(0, ball.size() / 2));
  std::string damaged = ball;
  damaged[damaged.size() / 2] = static_cast<char>(damaged[damaged.size() / 2] ^ 1);
  write_file(bench / "damaged.rho", damaged);
  const std::string box = read_file(bench / "box.vtu");
  write_file(bench / "truncated.vtu", box.substr(0, box.size() / 2));
  write_file(bench / "there.png", "a picture that someone needs");
  write_file(bench / "there.rho", "a file that someone needs");
  write_file(bench / "open.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  std::filesystem::create_directory(bench / "folder");
}

const Case cases[] = {
    // the command line itself
    {"no subcommand", {}, 2, "rhoray: no subcommand given", "--help"},
    {"mistyped subcommand", {"rendr", "ball.rho"}, 2, "no subcommand rendr", "did you mean render?"},
    {"mistyped option", {"render", "ball.rho", "--sise", "64x64"}, 2, "unknown option --sise", "did you mean --size?"},
    {"mistyped option with =", {"render", "ball.rho", "--ios=3"}, 2, "unknown option --ios", "did you mean --iso?"},
    {"unknown option", {"info", "ball.rho", "--flamingo"}, 2, "unknown option --flamingo", "lists the options"},
    {"mistyped option without a file", {"pack", "--hlep"}, 2, "unknown option --hlep", "did you mean --help?"},
    {"no file", {"render"}, 2, "no FILE given"},
    {"too many files", {"pack", "ball.rho", "box.rho"}, 2, "unexpected argument 'box.rho'"},
    {"nothing to list", {"info"}, 2, "no FILE given"},
    {"no option at all", {"tetrahedralize"}, 2, "no "},
    {"an option of another subcommand", {"info", "ball.rho", "--iso", "3"}, 2, "unknown option --iso", "lists"},
    {"one dash too few", {"render", "ball.rho", "-iso", "3"}, 2, "unknown option -iso", "did you mean --iso?"},
    {"a flag with a value", {"render", "ball.rho", "--ao=3"}, 2, "--ao"},
    {"an empty word", {"render", "ball.rho", "--mode", ""}, 2, "--mode: found ''", ""},
    {"a word in capitals", {"render", "ball.rho", "--mode", "MIP"}, 2, "--mode: found 'MIP'", "did you mean mip?"},

    // what other programs call it
    {"--isovalue", {"render", "ball.rho", "--isovalue", "3"}, 2, "unknown option --isovalue", "is --iso here"},
    {"--threshold", {"render", "ball.rho", "--threshold", "3"}, 2, "unknown option --threshold", "is --iso here"},
    {"--width", {"render", "ball.rho", "--width", "64"}, 2, "unknown option --width", "--size WIDTHxHEIGHT"},
    {"--height", {"render", "ball.rho", "--height", "64"}, 2, "unknown option --height", "--size WIDTHxHEIGHT"},
    {"--out", {"render", "ball.rho", "--out", "x.png"}, 2, "unknown option --out", "is -o here"},
    {"--overwrite", {"render", "ball.rho", "--overwrite"}, 2, "unknown option --overwrite", "is --force here"},
    {"--array", {"render", "box.rho", "--array", "height"}, 2, "unknown option --array", "is --field here"},
    {"--cmap", {"render", "box.rho", "--cmap", "viridis"}, 2, "unknown option --cmap", "is --colormap here"},
    {"--bg", {"render", "ball.rho", "--bg", "white"}, 2, "unknown option --bg", "is --background here"},
    {"--alpha", {"render", "ball.rho", "--alpha", "0.5"}, 2, "unknown option --alpha", "is --opacity here"},
    {"--jobs", {"pack", "box.vtu", "--jobs", "2"}, 2, "unknown option --jobs", "is --threads here"},
    {"--clip", {"render", "ball.rho", "--clip", "0,0,0,1,1,1"}, 2, "unknown option --clip", "--clip-plane or"},
    {"an option that the subcommand lacks", {"info", "ball.rho", "--isovalue", "3"}, 2, "unknown option --isovalue"},
    {"convert", {"convert", "ball.raw", "x.rho"}, 2, "no subcommand convert", "pack, export or import here"},
    {"show", {"show", "ball.rho"}, 2, "no subcommand show", "is render here"},
    {"isosurface", {"isosurface", "ball.rho"}, 2, "no subcommand isosurface", "render --iso here"},
    {"mip", {"mip", "ball.rho"}, 2, "no subcommand mip", "render --mode mip here"},
    {"inspect", {"inspect", "ball.rho"}, 2, "no subcommand inspect", "is info here"},
    {"diff", {"diff", "a.png", "b.png"}, 2, "no subcommand diff", "is compare here"},
    {"unpack", {"unpack", "ball.rho"}, 2, "no subcommand unpack", "is export here"},
    {"option without its value", {"render", "ball.rho", "--iso"}, 2, "--iso: found no value at the end; expected V"},
    {"option before another, without its value",
     {"render", "ball.rho", "--iso", "--mode", "mip"},
     2,
     "--iso: found no value before --mode; expected V",
     "write --iso=--mode if it is the value"},
    {"output before another option, without its name", {"render", "ball.rho", "-o", "-q"}, 2, "-o: found no value"},
    {"short flag with a value", {"render", "ball.rho", "-q=3"}, 2, "--quiet: takes no value; found '-q=3'"},
    {"help with a value", {"render", "--help=3"}, 2, "--help: takes no value; found '--help=3'"},
    {"a value beyond 32 bits", {"pack", "box.vtu", "--levels", "99999999999999999999", "-o", "x.rho"}, 2, "--levels"},
    {"a number as an option", {"render", "ball.rho", "-1"}, 2, "unknown option -1"},
    {"mistyped word", {"render", "ball.rho", "--mode", "mop"}, 2, "--mode: found 'mop'", "did you mean mip?"},

    // inputs that are missing, empty, cut off, of the wrong kind, damaged
    {"missing", {"render", "bal.rho", "-o", "x.png"}, 3, "bal.rho: no such file", "did you mean ball.rho?"},
    {"missing for info", {"info", "ball.rhp"}, 3, "ball.rhp: no such file", "did you mean ball.rho?"},
    {"missing for verify", {"verify", "bxo.rho"}, 3, "bxo.rho: no such file", "did you mean box.rho?"},
    {"missing for pack", {"pack", "boxx.vtu"}, 3, "boxx.vtu: no such file", "did you mean box.vtu?"},
    {"missing for tetrahedralize", {"tetrahedralize", "oppen.off"}, 3, "no such file", "did you mean open.off?"},
    {"missing for bench", {"bench", "phases", "nothing-like-it"}, 3, "no such file"},
    {"folder as input", {"info", "folder"}, 3, "is a folder"},
    {"empty packed file", {"render", "empty.rho", "-o", "x.png"}, 4, "empty.rho"},
    {"empty volume", {"pack", "empty.nrrd", "-o", "x.rho"}, 4, "empty.nrrd"},
    {"empty mesh", {"pack", "empty.vtu", "-o", "x.rho"}, 4, "empty.vtu"},
    {"empty surface", {"tetrahedralize", "empty.stl", "-o", "x.vtu"}, 4, "empty.stl"},
    {"truncated packed file", {"render", "truncated.rho", "-o", "x.png"}, 4, "truncated.rho"},
    {"truncated mesh", {"pack", "truncated.vtu", "-o", "x.rho"}, 4, "truncated.vtu"},
    {"text as packed file", {"render", "text.rho", "-o", "x.png"}, 4, "text.rho"},
    {"damaged packed file",
     {"render", "damaged.rho", "-o", "x.png"},
     4,
     "are damaged (array",
     "rhoray verify damaged.rho"},
    {"options of a mesh for a surface", {"pack", "open.off", "--cell-data", "-o", "x.rho"}, 2, "is a surface"},
    {"fields of a surface", {"pack", "open.off", "--field", "a", "-o", "x.rho"}, 2, "has no fields"},
    {"surface where fields are wanted", {"validate", "open.off", "--iso", "1", "-q"}, 7, "holds a surface"},
    {"surface for a table", {"bench", "views", "open.off", "-q"}, 7, "holds a surface"},
    {"isovalue of a surface", {"render", "open.off", "--iso", "3", "-o", "x.png"}, 2, "--iso: needs a field"},
    {"projection of a surface", {"render", "open.off", "--mode", "mip", "-o", "x.png"}, 2, "--mode: needs a field"},
    {"surface to export", {"export", "open.off", "-o", "x.vtu"}, 7, "holds a surface"},
    {"empty volume to render", {"render", "empty.nrrd", "-o", "x.png"}, 4, "empty.nrrd"},
    {"truncated mesh to render", {"render", "truncated.vtu", "-o", "x.png"}, 4, "truncated.vtu"},
    {"missing to render, foreign", {"render", "boxx.vtu"}, 3, "boxx.vtu: no such file", "did you mean box.vtu?"},
    {"missing layer", {"render", "ball.rho", "boxx.vtu", "-o", "x.png"}, 3, "boxx.vtu: no such file"},
    {"layer beside a scene",
     {"render", R"({"data": {"b": {"file": "ball.rho"}}, "layers": [{"type": "mip"}]})", "ball.rho", "-o", "x.png"},
     2,
     "ball.rho: not allowed with the scene"},
    {"picture without a scene", {"render", "there.png", "-o", "x.png"}, 4, "there.png"},
    {"packed file where a mesh is wanted",
     {"pack", "ball.rho", "-o", "x.rho"},
     7,
     "is already a packed file",
     "rhoray info"},
    {"unknown kind for pack", {"pack", "notes.txt", "-o", "x.rho"}, 7, "unsupported file type", "--raw"},
    {"mesh to verify", {"verify", "box.vtu"}, 7, "not a packed file", "rhoray pack box.vtu -o box.rho"},
    {"unknown kind to verify", {"verify", "notes.txt"}, 7, "not a packed file", "rhoray formats"},
    {"unknown kind to resample",
     {"resample", "notes.txt", "--spacing", "1", "-o", "x.rho"},
     7,
     "unsupported file type"},
    {"unknown kind to import", {"import", "notes.txt", "-o", "x.vtu"}, 7, "is not a mesh"},
    {"file with a header as samples",
     {"pack", "box.vtu", "--raw", "2x2x2:uint8", "-o", "x.rho"},
     2,
     "--raw: box.vtu begins with a header (VTK XML)",
     "leave out --raw"},
    {"packed file as samples", {"pack", "ball.rho", "--raw", "2x2x2:uint8", "-o", "x.rho"}, 2, "already a packed file"},
    {"time step of a surface", {"pack", "open.off", "--time", "last", "-o", "x.rho"}, 2, "has no time steps"},
    {"time step of samples",
     {"pack", "ball.raw", "--raw", "24x24x24:uint8", "--time", "last", "-o", "x.rho"},
     2,
     "found no time steps"},
    {"unknown kind for info", {"info", "notes.txt"}, 7, "unsupported file type", ".nrrd"},
    {"mesh where a surface is wanted", {"tetrahedralize", "box.vtu", "-o", "x.vtu"}, 7, "is not a surface"},
    {"open surface", {"tetrahedralize", "open.off", "-o", "x.vtu"}, 4, "open.off"},
    {"table on a raw file", {"bench", "phases", "ball.raw"}, 7, "ball.raw: unsupported file type"},
    {"unknown kind for render", {"render", "notes.txt"}, 7, "notes.txt: unsupported file type"},
    {"unknown kind for export", {"export", "notes.txt", "-o", "x.vti"}, 7, "notes.txt: unsupported file type"},
    {"unknown kind for validate", {"validate", "notes.txt", "--iso", "1"}, 7, "notes.txt: unsupported file type"},
    {"unknown kind for accuracy", {"accuracy", "notes.txt", "-o", "x"}, 7, "notes.txt: unsupported file type"},
    {"no file name", {"render", "", "-o", "x.png"}, 2, ""},

    // requests that make no sense
    {"no such field", {"render", "box.rho", "--field", "heigth", "-o", "x.png"}, 2, "heigth", "did you mean height?"},
    {"no such field to pack", {"pack", "box.vtu", "--field", "heigth", "-o", "x.rho"}, 2, "heigth", "height"},
    {"isovalue outside the range",
     {"render", "ball.rho", "--iso", "9000", "-o", "x.png"},
     2,
     "outside the range 0 to 2",
     "auto chooses one"},
    {"isovalue that is no number", {"render", "ball.rho", "--iso", "skin", "-o", "x.png"}, 2, "--iso: found 'skin'"},
    {"isovalue nan", {"render", "ball.rho", "--iso", "nan", "-o", "x.png"}, 2, "--iso: found 'nan'"},
    {"isovalue infinite", {"render", "ball.rho", "--iso", "inf", "-o", "x.png"}, 2, "--iso: found 'inf'"},
    {"isovalue beyond all numbers", {"render", "ball.rho", "--iso", "-1e999", "-o", "x.png"}, 2, "found '-1e999'"},
    {"isovalue nan to validate", {"validate", "ball.rho", "--iso", "nan"}, 2, "--iso: found 'nan'"},
    {"isovalue nan to export", {"export", "ball.rho", "--iso", "nan", "-o", "x.stl"}, 2, "--iso: found 'nan'"},
    {"percentile above 100",
     {"render", "ball.rho", "--iso", "p101", "-o", "x.png"},
     2,
     "--iso p101: percentiles run from 0 to 100"},
    {"isovalue of a projection",
     {"render", "ball.rho", "--mode", "mip", "--iso", "3", "-o", "x.png"},
     2,
     "--iso: needs an isosurface",
     "add --mode iso"},
    {"normals of a projection",
     {"render", "ball.rho", "--mode", "mip", "--normals", "exact", "-o", "x.png"},
     2,
     "--normals: needs an isosurface"},
    {"colour of a projection's surface",
     {"render", "ball.rho", "--mode", "mip", "--surface-color", "red", "-o", "x.png"},
     2,
     "--surface-color: needs an isosurface"},
    {"colour map with nothing coloured",
     {"render", "ball.rho", "--colormap", "viridis", "-o", "x.png"},
     2,
     "--colormap: needs --color-by"},
    {"range with nothing coloured", {"render", "ball.rho", "--range", "0,1", "-o", "x.png"}, 2, "needs --color-by"},
    {"empty range",
     {"render", "ball.rho", "--mode", "mip", "--range", "3,3", "-o", "x.png"},
     2,
     "--range: found '3,3'"},
    {"range backwards", {"render", "ball.rho", "--mode", "mip", "--range", "9,3", "-o", "x.png"}, 2, "--range"},
    {"range of one number", {"render", "ball.rho", "--mode", "mip", "--range", "9", "-o", "x.png"}, 2, "--range"},
    {"colour by nothing", {"render", "box.rho", "--color-by", "lenght", "-o", "x.png"}, 2, "lenght", "length"},
    {"colour and texture",
     {"render", "box.rho", "--texture", "ball.rho", "-o", "x.png"},
     7,
     "ball.rho: holds a grid",
     "--color"},
    {"unknown colour map", {"render", "box.rho", "--colormap", "jet", "-o", "x.png"}, 2, "--colormap: found 'jet'"},
    {"unknown colour", {"render", "ball.rho", "--background", "whitee", "-o", "x.png"}, 2, "--background: found"},
    {"colour of two numbers", {"render", "ball.rho", "--background", "1,1", "-o", "x.png"}, 2, "--background: found"},
    {"colour beyond 1", {"render", "ball.rho", "--background", "1,1,2", "-o", "x.png"}, 2, "--background: found"},
    {"colour of five digits",
     {"render", "ball.rho", "--background", "#12345", "-o", "x.png"},
     2,
     "--background: found"},
    {"opacity above 1", {"render", "ball.rho", "--opacity", "1.5", "-o", "x.png"}, 2, "--opacity: found '1.5'"},
    {"opacity below 0", {"render", "ball.rho", "--opacity", "-1", "-o", "x.png"}, 2, "--opacity: found '-1'"},
    {"ambient light above 1", {"render", "ball.rho", "--ambient", "2", "-o", "x.png"}, 2, "--ambient: found '2'"},
    {"field of view of 0", {"render", "ball.rho", "--fov", "0", "-o", "x.png"}, 2, "--fov: found '0'"},
    {"field of view of 180", {"render", "ball.rho", "--fov", "180", "-o", "x.png"}, 2, "--fov: found '180'"},
    {"zoom of 0", {"render", "ball.rho", "--zoom", "0", "-o", "x.png"}, 2, "--zoom: found '0'"},
    {"elevation above 90", {"render", "ball.rho", "--elevation", "91", "-o", "x.png"}, 2, "--elevation: found '91'"},
    {"position of two numbers",
     {"render", "ball.rho", "--camera-position", "1,2", "-o", "x.png"},
     2,
     "--camera-position: found '1,2'"},
    {"no samples in a pixel", {"render", "ball.rho", "--antialias", "0", "-o", "x.png"}, 2, "--antialias: found '0'"},
    {"too many samples in a pixel", {"render", "ball.rho", "--antialias", "99", "-o", "x.png"}, 2, "--antialias"},
    {"half a sample in a pixel", {"render", "ball.rho", "--antialias", "1.5", "-o", "x.png"}, 2, "--antialias"},
    {"slice on no axis", {"render", "ball.rho", "--slice", "w=3", "-o", "x.png"}, 2, "--slice: found 'w=3'"},
    {"slice without a normal",
     {"render", "ball.rho", "--slice", "0,0,0,0,0,0", "-o", "x.png"},
     2,
     "--slice: found '0,0,0,0,0,0'"},
    {"clip plane without a normal",
     {"render", "ball.rho", "--clip-plane", "0,0,0,0,0,0", "-o", "x.png"},
     2,
     "--clip-plane: found"},
    {"URL as the host of a proxy",
     {"view", "ball.rho", "--allow-host", "https://hub.example.org"},
     2,
     "--allow-host: found 'https://hub.example.org'; expected a host name"},
    {"clip box inside out", {"render", "ball.rho", "--clip-box", "9,9,9,0,0,0", "-o", "x.png"}, 2, "--clip-box: found"},
    {"light without an elevation", {"render", "ball.rho", "--light", "30", "-o", "x.png"}, 2, "--light: found '30'"},
    {"fog backwards", {"render", "ball.rho", "--fog", "9,3", "-o", "x.png"}, 2, "--fog"},
    {"unknown accuracy",
     {"render", "ball.rho", "--accuracy", "excat", "-o", "x.png"},
     2,
     "--accuracy: found 'excat'",
     "did you mean exact?"},
    {"unknown method", {"render", "ball.rho", "--method", "papre", "-o", "x.png"}, 2, "papre", "paper"},
    {"method with a step of 0",
     {"render", "ball.rho", "--method", "sampled:0", "-o", "x.png"},
     2,
     "expected a number from"},
    {"error heat map of a fast method",
     {"render", "ball.rho", "--show", "error", "-o", "x.png"},
     2,
     "the channel 'error' needs accuracy certified or exact"},
    {"unknown heat map", {"render", "ball.rho", "--show", "heat", "-o", "x.png"}, 2, "--show: found 'heat'"},
    {"no error allowed", {"render", "ball.rho", "--max-error", "0", "-o", "x.png"}, 2, "--max-error"},
    {"limit without a check", {"render", "ball.rho", "--verify-limit", "1", "-o", "x.png"}, 2, "needs --verify"},
    {"pixel outside the picture",
     {"render", "ball.rho", "--size", "64x64", "--pick", "99,0", "-o", "x.png"},
     2,
     "--pick"},
    {"pixel of one number", {"render", "ball.rho", "--pick", "9", "-o", "x.png"}, 2, "--pick: found '9'"},
    {"frames without a number", {"render", "ball.rho", "--frames", "0", "-o", "x_%d.png"}, 2, "--frames: found '0'"},
    {"frame of no path", {"render", "ball.rho", "--frame", "3", "-o", "x.png"}, 2, "frame"},
    {"unknown space", {"render", "ball.rho", "--space", "lpi", "-o", "x.png"}, 2, "--space: found 'lpi'", "lps"},
    {"threads below 0", {"render", "ball.rho", "--threads", "-1", "-o", "x.png"}, 2, "--threads: found '-1'"},
    {"memory of no number", {"pack", "box.vtu", "--memory", "lots", "-o", "x.rho"}, 2, "--memory: found 'lots'"},
    {"memory of 0", {"pack", "box.vtu", "--memory", "0", "-o", "x.rho"}, 2, "--memory: found '0'"},
    {"picture and numbers on stdout", {"render", "ball.rho", "-o", "-", "--json"}, 2, "-o -: writes the picture"},
    {"no pixels", {"render", "ball.rho", "--size", "0x0", "-o", "x.png"}, 2, "--size: found '0x0'"},
    {"absurdly many pixels", {"render", "ball.rho", "--size", "1000000x1000000", "-o", "x.png"}, 2, "from 1 to 65536"},
    {"more pixels than memory",
     {"render", "ball.rho", "--size", "4096x4096", "--memory", "1M", "-o", "x.png"},
     5,
     "--memory allows 1.0 MiB"},
    {"unknown picture format", {"render", "ball.rho", "-o", "x.bmp"}, 2, "expected .png"},
    {"channels in a PNG", {"render", "ball.rho", "--channels", "depth", "-o", "x.png"}, 2, "only EXR stores"},
    {"unknown channel",
     {"render", "ball.rho", "--channels", "deptj", "-o", "x.exr"},
     2,
     "found 'deptj'",
     "did you mean depth?"},
    {"unknown view", {"render", "ball.rho", "--view", "+w", "-o", "x.png"}, 2, "+w"},
    {"camera without a direction",
     {"render", "ball.rho", "--camera-position", "0,0,0", "--camera-target", "0,0,0", "-o", "x.png"},
     2,
     "no direction"},
    {"a single layer of voxels",
     {"pack", "ball.raw", "--raw", "144x96x1:uint8", "-o", "x.rho"},
     4,
     "found 144 x 96 x 1 samples; expected 2 to 1048576 on every axis"},
    {"spacing of zero",
     {"pack", "ball.raw", "--raw", "24x24x24:uint8", "--spacing", "1,0,1", "-o", "x.rho"},
     2,
     "spacing: found 1, 0, 1; expected three finite numbers above 0"},
    {"spacing too small to be inverted",
     {"pack", "ball.raw", "--raw", "24x24x24:uint8", "--spacing", "1e-320,1,1", "-o", "x.rho"},
     4,
     "not too small to be inverted",
     "give the spacing"},
    {"raw beyond the file",
     {"pack", "ball.raw", "--raw", "100x100x100:uint16:le", "-o", "x.rho"},
     4,
     "found 13824 bytes"},
    {"raw beyond 64 bits",
     {"pack", "ball.raw", "--raw", "4000000000x4000000000x4000000000:uint8", "-o", "x.rho"},
     4,
     "found 13824 bytes"},
    {"raw that cannot be read", {"pack", "ball.raw", "--raw", "24x24:uint8", "-o", "x.rho"}, 2, "24x24:uint8"},
    {"a memory cap that no run keeps to",
     {"pack", "ball.raw", "--raw", "24x24x24:uint8", "--memory", "1K", "-o", "x.rho"},
     2,
     "found a cap of 1024 bytes; expected at least 16M"},
    {"volume option on a mesh",
     {"pack", "box.vtu", "--layout", "linear", "-o", "x.rho"},
     2,
     "--layout: only for volumes"},
    {"mesh option on a volume",
     {"pack", "ball.raw", "--raw", "24x24x24:uint8", "--cells", "5", "-o", "x.rho"},
     2,
     "--cells: only for meshes"},
    {"too many levels",
     {"pack", "box.vtu", "--structure", "leaves", "--levels", "99", "-o", "x.rho"},
     2,
     "--levels: found 99"},
    {"brick of one sample",
     {"pack", "ball.raw", "--raw", "24x24x24:uint8", "--brick-edge", "1", "-o", "x.rho"},
     2,
     "1"},
    {"brick edge without bricks",
     {"pack", "ball.raw", "--raw", "24x24x24:uint8", "--layout", "linear", "--brick-edge", "4", "-o", "x.rho"},
     2,
     "--brick-edge: has no effect"},
    {"raw bytes of an unknown type", {"pack", "ball.raw", "--raw", "24x24x24:uint7", "-o", "x.rho"}, 2, "uint7"},
    {"unknown layout",
     {"pack", "ball.raw", "--raw", "24x24x24:uint8", "--layout", "brick", "-o", "x.rho"},
     2,
     "--layout: found 'brick'",
     "did you mean bricks?"},
    {"leaf lists without leaves", {"pack", "box.vtu", "--cells", "9", "-o", "x.rho"}, 2, "--structure leaves"},
    {"a smaller type that changes values",
     {"pack", "ball.raw", "--raw", "24x24x24:uint8", "--type", "I8", "-o", "x.rho"},
     4,
     "I8"},
    {"export to an unknown format", {"export", "ball.rho", "-o", "x.vtx"}, 2, "x.vtx", "did you mean .vti?"},
    {"export without a name", {"export", "ball.rho"}, 2, "-o: missing"},
    {"export of a grid as a mesh", {"export", "ball.rho", "-o", "x.vtu"}, 7, "is a grid", ".vti"},
    {"export of a mesh as a grid", {"export", "box.rho", "-o", "x.vti"}, 7, "is a mesh", ".vtu"},
    {"a surface of a grid without an isovalue", {"export", "ball.rho", "-o", "x.stl"}, 2, "--iso: missing"},
    {"an isovalue of a grid that stays one", {"export", "ball.rho", "--iso", "9", "-o", "x.vti"}, 2, "only for .stl"},
    {"one field of a format that holds all", {"export", "box.rho", "--field", "height", "-o", "x.vtu"}, 2, "--field"},
    {"a single picture to compare", {"compare", "there.png"}, 2, "compare"},
    {"no repetition", {"bench", "open", "ball.rho", "--repeat", "0"}, 2, "--repeat: found 0"},
    {"unknown table", {"bench", "thread", "ball.rho"}, 2, "no table 'thread'", "did you mean threads?"},

    // outputs
    {"picture is there", {"render", "ball.rho", "-o", "there.png"}, 2, "there.png already exists", "--force"},
    {"packed file is there", {"pack", "box.vtu", "-o", "there.rho"}, 2, "there.rho already exists", "--force"},
    {"default output is there", {"pack", "box.vtu"}, 2, "box.rho already exists", "--force"},
    {"folder of the output is missing", {"render", "ball.rho", "-o", "nowhere/x.png"}, 2, "no folder nowhere"},
    {"folder of the packed file is missing", {"pack", "box.vtu", "-o", "nowhere/x.rho"}, 2, "no folder nowhere"},
    {"output is a folder", {"pack", "box.vtu", "-o", "folder"}, 2, "is a folder"},
    {"output is the input",
     {"pack", "ball.raw", "--raw", "24x24x24:uint8", "-o", "ball.raw", "--force"},
     2,
     "is the input"},
    {"a word behind --version", {"--version", "foo"}, 2, "unexpected foo"},
    {"mesh of another format", {"tetrahedralize", "open.off", "-o", "x.msh"}, 2, "expected .vtu"},
    {"folder for tables is missing", {"bench", "open", "ball.rho", "-o", "nowhere"}, 2, "no such folder"}};

/// Words of the libraries that read command lines and files: messages are in ours.
const char* const words_of_libraries[] = {"RequiredError",
                                          "ValidationError",
                                          "ExtrasError",
                                          "ArgumentMismatch",
                                          "were not expected",
                                          "is required",
                                          " required ",
                                          "libpng",
                                          "IHDR",
                                          "OpenImageIO",
                                          "OIIO",
                                          "vtkXML",
                                          "vtkDebug",
                                          "Generic Warning",
                                          "HDF5-DIAG",
                                          "H5F",
                                          "[nrrd]",
                                          "nrrdLoad",
                                          "std::",
                                          "basic_string",
                                          "vector::",
                                          "terminate",
                                          "internal error",
                                          "filesystem error"};

TEST(BadInput, ends_with_the_right_code_one_line_of_fact_a_hint_and_nothing_written) {
  const Workbench bench;
  make_inputs(bench);
  const auto before = bench.contents();
  for (const Case& each : cases) {
    SCOPED_TRACE(each.name);
    const RunResult result = bench.rhoray(each.words);
    EXPECT_EQ(result.exit_code, each.exit_code) << result.err;
    EXPECT_EQ(result.out, "");
    const std::string first = result.err.substr(0, result.err.find('\n'));
    EXPECT_THAT(first, testing::StartsWith("rhoray"));
    EXPECT_THAT(first, HasSubstr(each.fact));
    EXPECT_THAT(line_after(result.err, "hint: "), HasSubstr(each.hint));
    EXPECT_LE(std::count(result.err.begin(), result.err.end(), '\n'), 2) << result.err;
    for (const char* const word : words_of_libraries) EXPECT_THAT(result.err, testing::Not(HasSubstr(word)));
    EXPECT_EQ(bench.contents(), before);
  }
}

TEST(BadInput, stays_bad_for_every_cut_of_a_packed_file) {
  const Workbench bench;
  bench.make_ball();
  const std::string ball = read_file(bench / "ball.rho");
  const std::size_t steps = 16;
  for (std::size_t i = 0; i < steps; ++i) {
    write_file(bench / "cut.rho", ball.substr(0, ball.size() * i / steps));
    EXPECT_EQ(bench.rhoray({"render", "cut.rho", "-o", "cut.png"}).exit_code, 4) << i;
    EXPECT_EQ(bench.rhoray({"verify", "cut.rho"}).exit_code, 4) << i;
    EXPECT_FALSE(std::filesystem::exists(bench / "cut.png"));
  }
}

TEST(BadInput, that_cannot_be_opened_is_unreadable) {
  const Workbench bench;
  bench.make_ball();
  // A name that leads nowhere, for root too.
  std::filesystem::create_symlink("loop.rho", bench / "loop.rho");
  std::filesystem::permissions(bench / "ball.rho", std::filesystem::perms::none);
  std::vector<std::string> files{"loop.rho"};
  if (::geteuid() != 0) files.push_back("ball.rho");  // root may read every file
  for (const std::string& file : files) {
    EXPECT_EQ(bench.rhoray({"render", file}).exit_code, 3) << file;
    EXPECT_EQ(bench.rhoray({"verify", file}).exit_code, 3) << file;
  }
}

}  // namespace
}  // namespace rhoray::tests
