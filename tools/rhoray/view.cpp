#include <malloc.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <climits>
#include <cstdlib>
#include <exception>
#include <functional>
#include <memory>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "formats/base/error.h"
#include "formats/packed_file.h"
#include "tools/pictures/annotations.h"
#include "tools/pictures/pictures.h"
#include "tools/rhoray/cli/interrupt.h"
#include "tools/rhoray/cli/options.h"
#include "tools/rhoray/cli/version.h"
#include "tools/rhoray/damage.h"
#include "tools/rhoray/data_choice.h"
#include "tools/rhoray/render/asked_scene.h"
#include "tools/rhoray/render/label_layers.h"
#include "tools/rhoray/render/picture.h"
#include "tools/rhoray/render/reproduce.h"
#include "tools/rhoray/report.h"
#include "tools/rhoray/subcommands.h"
#include "tools/view/client_message.h"
#include "tools/view/line_exchange.h"
#include "tools/view/server.h"

namespace rhoray::tools {

namespace {

struct ViewCommand {
  CommonOptions common;
  std::vector<std::filesystem::path> inputs;
  PictureOptions picture;
  std::optional<int> port;
  std::filesystem::path socket;
  std::vector<HostName> hosts;
  bool opens_no_browser = false;
  bool uses_stdio = false;
};

/// Opens the page in the user's browser, if a desktop is there to open it on.
void open_browser(const std::string& url) {
  if (std::getenv("DISPLAY") == nullptr && std::getenv("WAYLAND_DISPLAY") == nullptr) return;
  const pid_t child = ::fork();
  if (child != 0) {
    if (child > 0) ::waitpid(child, nullptr, 0);
    return;
  }
  if (::fork() == 0) {  // the browser outlives the command that starts it, and is nobody's zombie
    ::execlp("xdg-open", "xdg-open", url.c_str(), static_cast<char*>(nullptr));
    ::_exit(127);
  }
  ::_exit(0);
}

/// @param display  must outlive the scene
ViewedScene opened(const ViewCommand& command, ProgressDisplay& display) {
  render::SceneSpec asked = asked_scene(command.picture, command.inputs, command.common);
  if (asked.camera.keyframes) throw Error(ErrorCode::usage, "a scene with a camera path is a film; `render` draws it");
  display.show(concat("opening ", asked.data[0].file.string()));
  // Scenes and pictures that the page saves name these files, and lie in another folder.
  for (render::DataSpec& data : asked.data) data.file = std::filesystem::absolute(data.file).lexically_normal();
  DataAccess access = access_for(command.common, display);
  access.loaded = std::make_shared<DataAccess::Loaded>();
  const std::filesystem::path& input = command.inputs.front();
  ViewedScene viewed{.title = (render::is_scene_document(input) ? input.stem() : input.filename()).string(),
                     .program = concat("rhoray ", version()),
                     .scene_spec = with_label_layers(asked, access)};
  viewed.plan = resolve_layers(viewed.scene_spec, access);
  const std::filesystem::path output = default_output(input, ".png");
  settle_annotations(viewed.scene_spec, output, viewed.plan);
  if (has_texts(viewed.plan)) find_font(known_fonts());  // refused now, not at the first picture
  aim_camera(viewed.scene_spec, viewed.plan);
  viewed.resolve = [access](const render::SceneSpec& changed) { return resolve_layers(changed, access); };
  viewed.command_of = [output](const render::ResolvedScene& plan) {
    return shell_line(reproducing_command(plan, output));
  };
  viewed.texts_of = [command_of = viewed.command_of](const render::ResolvedScene& plan, std::string_view machine) {
    return texts_of_picture(to_spec(plan), {}, command_of(plan), machine);
  };
  return viewed;
}

/// The packed files of data and textures.
std::vector<formats::PackedFile> files_of(const render::ResolvedScene& plan) {
  std::vector<formats::PackedFile> files;
  for (const render::Dataset& dataset : plan.datasets) files.push_back(dataset.file());
  for (const render::Texture& texture : plan.textures) files.push_back(texture.file());
  return files;
}

/// Serves until the token is told to stop. Meanwhile another thread checks the files. A damaged file
/// ends the server and is refused (ErrorCode::invalid).
/// @param serve  until its token is told to stop
void serve_undamaged(const std::vector<formats::PackedFile>& files, const std::stop_token& interrupt,
                     const std::function<void(const std::stop_token&)>& serve) {
  std::stop_source stop;
  const std::stop_callback interrupted(interrupt, [&] { stop.request_stop(); });
  std::exception_ptr damage;
  {
    const std::jthread check([&](const std::stop_token& served) {
      try {
        for (const formats::PackedFile& file : files) refuse_damage(file, 1, served);
      } catch (...) {
        if (served.stop_requested()) return;
        damage = std::current_exception();
        stop.request_stop();
      }
    });
    serve(stop.get_token());
  }
  if (damage) std::rethrow_exception(damage);
}

/// Serves until the token is told to stop, and exchanges the state of the view with the program
/// that started this one (PROTOCOL.md), until that closes its pipe.
/// @param told  where the server's messages go meanwhile
void serve_and_exchange(Server& server, LineExchange*& told, const std::stop_token& interrupt) {
  std::stop_source stop;
  const std::stop_callback interrupted(interrupt, [&] { stop.request_stop(); });
  const auto take = [&](std::string_view line) -> std::string {
    try {
      server.set(parse_program_message(line));
      return {};
    } catch (const Error& error) {
      return dump(Json{{"error", error.what()}});
    }
  };
  LineExchange exchange(STDIN_FILENO, STDOUT_FILENO, {.answer = take, .ended = [&] { stop.request_stop(); }});
  exchange.write(server.hello());
  told = &exchange;
  server.run(stop.get_token());
  told = nullptr;
}

/// Returns the command that makes a tunnel to the socket. The user types it on another machine.
std::string tunnel_line(std::uint16_t port, const std::filesystem::path& socket) {
  std::array<char, HOST_NAME_MAX + 1> host{};
  if (::gethostname(host.data(), host.size()) != 0)
    throw Error(ErrorCode::resource, concat("gethostname: ", std::system_category().message(errno)));
  return shell_line({"ssh", "-N", "-L", concat(port, ":", std::filesystem::absolute(socket).string()), host.data()});
}

/// Lets malloc map each large block separately. Otherwise pictures of many sizes leave holes
/// between small blocks: in an hour of random use the server's memory grew by 25 MiB.
void keep_large_blocks_apart() {
  constexpr int smallest_large_block = 1 << 20;
  ::mallopt(M_MMAP_THRESHOLD, smallest_large_block);
}

int run(const ViewCommand& command) {
  ProgressDisplay display(command.common);
  LineExchange* told = nullptr;
  std::function<void(std::string)> tell_program;  // none without --stdio: pages then share nothing
  if (command.uses_stdio)
    tell_program = [&](std::string text) {
      if (told == nullptr) return;
      if (text.starts_with(R"({"state")"))
        told->write_state(std::move(text));
      else
        told->write(std::move(text));
    };
  keep_large_blocks_apart();
  ViewedScene viewed = opened(command, display);
  const std::vector<formats::PackedFile> files = files_of(viewed.plan);
  Server server(std::move(viewed), {.port = static_cast<std::uint16_t>(command.port.value_or(0)),
                                    .socket = command.socket,
                                    .allowed_hosts = command.hosts,
                                    .threads = command.common.threads,
                                    .tell_program = tell_program});
  display.clear();
  const InterruptRequest interrupt("");  // once the URL is printed, an interrupt ends the server
  const bool prints_json = command.common.json || command.uses_stdio;
  std::puts(prints_json ? dump(Json{{"url", server.url()}}).c_str() : server.url().c_str());
  std::fflush(stdout);
  if (!command.socket.empty())
    say(command.common, concat("on your own machine: ", tunnel_line(server.port(), command.socket)));
  else if (!command.opens_no_browser)
    open_browser(server.url());
  say(command.common, "Ctrl+C ends it");
  serve_undamaged(files, interrupt.token(), [&](const std::stop_token& stop) {
    if (command.uses_stdio)
      serve_and_exchange(server, told, stop);
    else
      server.run(stop);
  });
  return 0;
}

}  // namespace

Subcommand view_subcommand() {
  const auto command = std::make_shared<ViewCommand>();
  return {
      .name = "view",
      .summary = "Explore data in the browser",
      .group = "Pictures",
      .examples = {"rhoray view head.nrrd", "rhoray view heart.rho --iso 0.3 --style presentation",
                   "rhoray view torso.json --port 8123 --no-browser",
                   "rhoray view head.rho --socket $XDG_RUNTIME_DIR/rhoray.sock"},
      .options = all_options(
          {{with_details(files_option("FILE", "Volume, mesh or surface, packed or not; or a scene document (.json)",
                                      command->inputs),
                         "As for `rhoray render`, whose options choose what is shown at first")},
           in_group(
               "Server",
               {number_option("--port", "N", "Port on the loopback interface; default a free one",
                              Interval<int>{1, 65535}, command->port),
                with_details(
                    value_option("--socket", "FILE", "Listen on a Unix socket instead of a port", command->socket),
                    "For machines with several users, of whom any could reach a port. Only you may "
                    "open the socket; the printed ssh command makes a tunnel to it, from --port (8123)"),
                value_option("--allow-host", "NAME[:PORT][,...]",
                             "Answer under these host names, too: those of a proxy", command->hosts),
                flag_option("--no-browser", "Print the URL without opening it", command->opens_no_browser),
                for_experts(with_details(
                    flag_option("--stdio", "Exchange the view's state with the program that starts this one",
                                command->uses_stdio),
                    "Each change of camera or scene is a line of JSON. Changes in the browser are written to stdout, "
                    "and changes of the program are read from stdin. The server ends when stdin ends. Implies "
                    "--json"))}),
           picture_options(command->picture),
           in_group("Input", read_options(command->picture.scene_spec.data[0].read)),
           in_group("Input", {cache_option(command->common)}),
           in_group("General", all_options({threads_option(command->common),
                                            message_options(command->common, "Print the URL as JSON to stdout")}))}),
      .run = [command] { return run(*command); }};
}

}  // namespace rhoray::tools
