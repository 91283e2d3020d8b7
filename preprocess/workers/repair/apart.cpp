#include "preprocess/workers/repair/apart.h"

#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <ctime>
#include <exception>
#include <new>
#include <span>

#include "formats/base/descriptor.h"
#include "formats/base/error.h"
#include "formats/base/library_text.h"
#include "preprocess/process/limits.h"

namespace rhoray::preprocess::repair {

namespace {

/// How the copy ends when it does not crash. Sanitizers end a crashing process with small numbers.
enum End { finished = 100, gave_up = 101, out_of_memory = 102 };

using Bytes = std::vector<std::byte>;

template <class T>
void append(Bytes& bytes, std::span<const T> values) {
  const auto added = std::as_bytes(values);
  bytes.insert(bytes.end(), added.begin(), added.end());
}

template <class T>
std::vector<T> take(std::span<const std::byte>& bytes, std::size_t count) {
  std::vector<T> values(count);
  std::memcpy(values.data(), bytes.data(), count * sizeof(T));
  bytes = bytes.subspan(count * sizeof(T));
  return values;
}

/// Counts, coordinates, and how the elements of a mesh without removed ones are linked. All indices
/// stay as they are.
Bytes bytes_of(const TriangleMesh& mesh) {
  const std::vector<std::uint32_t> counts{mesh.number_of_vertices(), mesh.number_of_halfedges(),
                                          mesh.number_of_faces()};
  std::vector<double> coordinates;
  std::vector<std::uint32_t> links;
  for (const auto v : mesh.vertices()) {
    const Point& p = mesh.point(v);
    coordinates.insert(coordinates.end(), {p.x(), p.y(), p.z()});
    links.push_back(mesh.halfedge(v).idx());
  }
  for (const auto h : mesh.halfedges())
    links.insert(links.end(), {mesh.target(h).idx(), mesh.next(h).idx(), mesh.face(h).idx()});
  for (const auto f : mesh.faces()) links.push_back(mesh.halfedge(f).idx());
  Bytes bytes;
  append<std::uint32_t>(bytes, counts);
  append<double>(bytes, coordinates);
  append<std::uint32_t>(bytes, links);
  return bytes;
}

TriangleMesh mesh_from(std::span<const std::byte> bytes) {
  using Vertex = TriangleMesh::Vertex_index;
  using Halfedge = TriangleMesh::Halfedge_index;
  using Face = TriangleMesh::Face_index;
  const auto counts = take<std::uint32_t>(bytes, 3);
  const auto coordinates = take<double>(bytes, std::size_t{3} * counts[0]);
  const auto links = take<std::uint32_t>(bytes, counts[0] + std::size_t{3} * counts[1] + counts[2]);
  TriangleMesh mesh;
  for (std::size_t v = 0; v < counts[0]; ++v)
    mesh.add_vertex(Point(coordinates[3 * v], coordinates[3 * v + 1], coordinates[3 * v + 2]));
  for (std::uint32_t edge = 0; edge < counts[1] / 2; ++edge) mesh.add_edge();
  for (std::uint32_t f = 0; f < counts[2]; ++f) mesh.add_face();
  auto link = links.begin();
  for (std::uint32_t v = 0; v < counts[0]; ++v) mesh.set_halfedge(Vertex(v), Halfedge(*link++));
  for (std::uint32_t h = 0; h < counts[1]; ++h) {
    mesh.set_target(Halfedge(h), Vertex(*link++));
    mesh.set_next(Halfedge(h), Halfedge(*link++));
    mesh.set_face(Halfedge(h), Face(*link++));
  }
  for (std::uint32_t f = 0; f < counts[2]; ++f) mesh.set_halfedge(Face(f), Halfedge(*link++));
  return mesh;
}

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

/// Takes CPU time that was used elsewhere off the limit of this process.
void shorten_time_limit(double used_s) {
  rlimit limit{};
  if (::getrlimit(RLIMIT_CPU, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return;
  const auto used = static_cast<rlim_t>(used_s);
  limit.rlim_cur = limit.rlim_cur > used ? limit.rlim_cur - used : 1;
  ::setrlimit(RLIMIT_CPU, &limit);
}

/// The copy's life: writes the resulting mesh and ends.
[[noreturn]] void be_copy(const TriangleMesh& mesh, std::optional<TriangleMesh> (*step)(TriangleMesh), int output) {
  try {
    const std::optional<TriangleMesh> result = step(mesh);
    if (!result) ::_exit(gave_up);
    const Bytes bytes = bytes_of(*result);
    for (std::size_t at = 0; at < bytes.size();) {
      const ssize_t count = ::write(output, bytes.data() + at, bytes.size() - at);
      if (count < 0 && errno != EINTR) ::_exit(gave_up);
      at += count < 0 ? 0 : static_cast<std::size_t>(count);
    }
    ::_exit(finished);
  } catch (const std::bad_alloc&) {
    ::_exit(out_of_memory);
  } catch (const std::exception& error) {
    note_library_text(error.what());
    ::_exit(gave_up);
  } catch (...) {  // the copy must not go on as if it were this process
    ::_exit(gave_up);
  }
}

/// Reads what the copy writes until it ends. Stops a copy that does nothing for a minute.
Bytes read_all(int input, pid_t copy) {
  constexpr double idle_limit_s = 60;
  IdleWatch watch(copy, idle_limit_s);
  Bytes bytes;
  std::byte piece[1 << 16];
  for (;;) {
    // Looking at the copy also shows those who watch this process that it is not idle.
    pollfd words{.fd = input, .events = POLLIN, .revents = 0};
    if (::poll(&words, 1, watch.pause_ms()) == 0) {
      if (watch.is_over(1e-3 * watch.pause_ms())) ::kill(copy, SIGKILL);
      continue;
    }
    const ssize_t count = ::read(input, piece, sizeof piece);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return bytes;
    bytes.insert(bytes.end(), piece, piece + count);
  }
}

[[noreturn]] void refuse_by_system(const char* call) {
  throw Error(ErrorCode::resource, concat("repairing a surface: ", call, ": ", std::strerror(errno)));
}

}  // namespace

std::optional<TriangleMesh> run_apart(const TriangleMesh& mesh, std::optional<TriangleMesh> (*step)(TriangleMesh)) {
  int ends[2];
  if (::pipe(ends) != 0) refuse_by_system("pipe");
  const Descriptor hear(ends[0]);
  Descriptor speak(ends[1]);
  const double used_s = static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
  const pid_t copy = ::fork();
  if (copy < 0) refuse_by_system("fork");
  if (copy == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    shorten_time_limit(used_s);
    be_copy(mesh, step, speak.number());
  }
  speak.close();
  const Bytes bytes = read_all(hear.number(), copy);

  int status = 0;
  rusage used{};
  while (::wait4(copy, &status, 0, &used) < 0 && errno == EINTR) {
  }
  shorten_time_limit(seconds_of(used.ru_utime) + seconds_of(used.ru_stime));
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU) ::raise(SIGXCPU);
  if (WIFEXITED(status) && WEXITSTATUS(status) == out_of_memory) throw std::bad_alloc();
  if (WIFEXITED(status) && WEXITSTATUS(status) == finished) return mesh_from(bytes);
  if (WIFSIGNALED(status))
    note_library_text(
        concat("CGAL was stopped by signal ", WTERMSIG(status), " (", ::strsignal(WTERMSIG(status)), ")"));
  return std::nullopt;
}

}  // namespace rhoray::preprocess::repair
