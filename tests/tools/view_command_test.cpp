#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include "tests/tools/started_program.h"
#include "tests/tools/workbench.h"

/// `rhoray view`: how it begins and ends. tests/tools/view looks into the server.
namespace rhoray::tests {
namespace {

using testing::HasSubstr;
using testing::MatchesRegex;

/// The first line that a program prints; nothing where it ends before.
std::string first_line(int descriptor) {
  std::string line;
  char letter = 0;
  while (::read(descriptor, &letter, 1) == 1 && letter != '\n') line += letter;
  return line;
}

/// Sends a request to a port of this machine and returns the answer.
std::string answer(int port, const std::string& request) {
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  std::string text;
  if (::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
      ::send(socket, request.data(), request.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(request.size())) {
    char bytes[4096];
    for (ssize_t count = 0; (count = ::recv(socket, bytes, sizeof bytes, 0)) > 0;)
      text.append(bytes, static_cast<std::size_t>(count));
  }
  ::close(socket);
  return text;
}

TEST(ViewCommand, prints_its_address_serves_and_ends_when_it_is_interrupted) {
  const Workbench bench;
  bench.make_box_vtu();
  const auto before = bench.contents();
  for (const int signal : {SIGINT, SIGTERM}) {
    int ends[2];
    ASSERT_EQ(::pipe2(ends, O_CLOEXEC), 0);
    StartedProgram program(bench.path(), {"view", "box.vtu", "--no-browser", "--no-cache"}, {.out = ends[1]});
    ::close(ends[1]);
    const std::string url = first_line(ends[0]);
    ASSERT_THAT(url, MatchesRegex("http://127\\.0\\.0\\.1:[0-9]+/#token=[0-9a-f]+")) << program.said();
    const int port = std::stoi(url.substr(std::string("http://127.0.0.1:").size()));
    EXPECT_THAT(answer(port, concat("GET / HTTP/1.1\r\nHost: 127.0.0.1:", port, "\r\n\r\n")), HasSubstr("200 OK"));
    EXPECT_THAT(answer(port, "GET / HTTP/1.1\r\nHost: evil.com\r\n\r\n"), HasSubstr("403 Forbidden"));
    program.send(signal);
    EXPECT_EQ(program.wait(), 0) << program.said();
    EXPECT_THAT(program.said(), testing::Not(HasSubstr("interrupted"))) << "it has no results to write";
    ::close(ends[0]);
  }
  EXPECT_EQ(bench.contents(), before) << "it writes no file";
}

TEST(ViewCommand, exchanges_lines_with_the_program_that_starts_it) {
  const Workbench bench;
  bench.make_box();
  int out[2], in[2];
  ASSERT_EQ(::pipe2(out, O_CLOEXEC), 0);
  ASSERT_EQ(::pipe2(in, O_CLOEXEC), 0);
  StartedProgram program(bench.path(), {"view", "box.rho", "--no-browser", "--stdio"}, {.out = out[1], .in = in[0]});
  ::close(out[1]), ::close(in[0]);
  EXPECT_THAT(first_line(out[0]), HasSubstr(R"({"url":"http://127.0.0.1:)")) << program.said();
  EXPECT_THAT(first_line(out[0]), HasSubstr(R"({"hello":)"));
  const std::string lines = "{\"set\": {\"n\": 1}}\n{\"set\": 5}\n";
  EXPECT_EQ(::write(in[1], lines.data(), lines.size()), static_cast<ssize_t>(lines.size()));
  EXPECT_THAT(first_line(out[0]), HasSubstr(R"("error":"message: \"set\")")) << "the first line is no error";
  ::close(in[1]);
  EXPECT_EQ(program.wait(), 0) << program.said();
  ::close(out[0]);
}

TEST(ViewCommand, says_how_another_machine_reaches_its_socket) {
  const Workbench bench;
  bench.make_box();
  int out[2];
  ASSERT_EQ(::pipe2(out, O_CLOEXEC), 0);
  StartedProgram program(bench.path(), {"view", "box.rho", "--socket", "my s.sock", "--port", "9000"}, {.out = out[1]});
  ::close(out[1]);
  EXPECT_THAT(first_line(out[0]), MatchesRegex("http://127\\.0\\.0\\.1:9000/#token=[0-9a-f]+"));
  program.send(SIGINT);
  EXPECT_EQ(program.wait(), 0);
  ::close(out[0]);
  char host[256];
  ASSERT_EQ(::gethostname(host, sizeof host), 0);
  EXPECT_THAT(program.said(), HasSubstr(concat("ssh -N -L '9000:", (bench / "my s.sock").string(), "' ", host, "\n")));
}

TEST(ViewCommand, ends_when_it_finds_that_a_file_is_damaged) {
  const Workbench bench;
  bench.make_ball();
  std::string bytes = read_file(bench / "ball.rho");
  bytes[bytes.size() / 2] ^= 0x40;
  write_file(bench / "ball.rho", bytes);
  StartedProgram program(bench.path(), {"view", "ball.rho", "--no-browser"});
  EXPECT_EQ(program.wait(), 4) << program.said();
  EXPECT_THAT(program.said(), HasSubstr("are damaged (array"));
}

TEST(ViewCommand, refuses_what_it_cannot_show_before_it_listens) {
  const Workbench bench;
  bench.make_box();
  write_file(bench / "s.json", R"({"data": {"m": {"file": "box.rho"}}, "layers": [{"type": "boundary"}],
    "camera": {"keyframes": [{"time": 0, "azimuth": 0}, {"time": 1, "azimuth": 90}]}})");
  const auto refusal = [&](const std::vector<std::string>& words, int exit_code) {
    const RunResult run = bench.rhoray(words);
    EXPECT_EQ(run.exit_code, exit_code) << run.err;
    EXPECT_EQ(run.out, "");
    return run.err;
  };
  EXPECT_THAT(refusal({"view", "missing.rho"}, 3), HasSubstr("missing.rho"));
  EXPECT_THAT(refusal({"view", "s.json"}, 2), HasSubstr("`render` draws it"));
  EXPECT_THAT(refusal({"view", "box.rho", "--port", "70000"}, 2), HasSubstr("--port"));
  EXPECT_THAT(refusal({"view", "box.rho", "--socket", "no/such/folder/s"}, 5), HasSubstr("no/such/folder/s"));
  EXPECT_THAT(refusal({"view", "box.rho", "--field", "pressure"}, 2), HasSubstr("pressure"));
}

}  // namespace
}  // namespace rhoray::tests
