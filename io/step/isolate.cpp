#include "io/step/isolate.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <new>
#include <optional>

#include "geometry/error.h"

#if defined(__SANITIZE_ADDRESS__)
#define AFPTRAJ_ADDRESS_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define AFPTRAJ_ADDRESS_SANITIZER 1
#endif
#endif

namespace afptraj::step {
namespace {

/// First byte of what the child sends.
enum class Tag : char { result = 'R', error = 'E', out_of_memory = 'M', unknown = 'U' };

void set_limit(int resource, rlim_t value) {
  rlimit limit{};
  ::getrlimit(static_cast<__rlimit_resource>(resource), &limit);
  limit.rlim_cur = std::min(value, limit.rlim_max);
  ::setrlimit(static_cast<__rlimit_resource>(resource), &limit);
}

void limit_child(const IsolationLimits& limits) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  for (const int signal :
       {SIGINT, SIGTERM, SIGHUP, SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL, SIGPIPE, SIGXFSZ}) {
    std::signal(signal, SIG_DFL);
  }
#ifndef AFPTRAJ_ADDRESS_SANITIZER
  set_limit(RLIMIT_AS, limits.memory_bytes);
#endif
  set_limit(RLIMIT_CPU, static_cast<rlim_t>(std::ceil(std::clamp(limits.timeout_s, 1.0, 1e6))) + 1);
  set_limit(RLIMIT_CORE, 0);
  set_limit(RLIMIT_FSIZE, 0);
  // A deep but finite recursion passes; an endless one ends soon, also where the stack is unlimited.
  set_limit(RLIMIT_STACK, rlim_t{64} << 20);
  const int null = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  for (int fd = 0; fd <= 2 && null >= 0; ++fd) ::dup2(null, fd);
}

/// False when the parent is gone.
bool send_all(int fd, const char* data, std::size_t size) {
  while (size > 0) {
    const ssize_t sent = ::write(fd, data, size);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    data += sent, size -= static_cast<std::size_t>(sent);
  }
  return true;
}

void send_message(int fd, Tag tag, const std::string& body) {
  const std::uint64_t size = body.size();
  char head[9] = {static_cast<char>(tag)};
  std::memcpy(head + 1, &size, sizeof size);
  if (send_all(fd, head, sizeof head)) send_all(fd, body.data(), body.size());
}

std::string pack_error(const Error& error) {
  return std::to_string(static_cast<int>(error.code())) + '\0' + error.where() + '\0' + error.what();
}

[[noreturn]] void throw_packed_error(const std::string& body, const std::string& where) {
  const std::size_t a = body.find('\0');
  const std::size_t b = a == std::string::npos ? a : body.find('\0', a + 1);
  if (b == std::string::npos)
    throw Error(ErrorCode::internal, where, "the STEP importer sent a broken message");
  throw Error(static_cast<ErrorCode>(std::atoi(body.c_str())), body.substr(a + 1, b - a - 1),
              body.substr(b + 1));
}

[[noreturn]] void run_child(int fd, const IsolationLimits& limits, const std::function<std::string()>& work) {
  limit_child(limits);
  try {
    send_message(fd, Tag::result, work());
  } catch (const Error& error) {
    send_message(fd, Tag::error, pack_error(error));
  } catch (const std::bad_alloc&) {
    send_message(fd, Tag::out_of_memory, "");
  } catch (const std::exception& error) {
    send_message(fd, Tag::unknown, error.what());
  } catch (...) {
    send_message(fd, Tag::unknown, "an exception of unknown type");
  }
  ::_exit(0);
}

/// The child and its pipe; whatever happens, no process and no descriptor is left behind.
class Child {
 public:
  Child(const std::string& where, const IsolationLimits& limits, const std::function<std::string()>& work) {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) fail(where);
    fd_ = ends[0];
    pid_ = ::fork();
    if (pid_ == 0) run_child(ends[1], limits, work);
    const int fault = errno;
    ::close(ends[1]);
    errno = fault;
    if (pid_ < 0) {
      ::close(fd_);
      fail(where);
    }
  }
  ~Child() {
    ::close(fd_);
    if (!status_) kill_and_wait();
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  int fd() const { return fd_; }
  void kill_and_wait() {
    ::kill(pid_, SIGKILL);
    wait();
  }
  int wait() {
    int status = 0;
    while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
    }
    status_ = status;
    return status;
  }

 private:
  [[noreturn]] static void fail(const std::string& where) {
    throw Error(ErrorCode::resource_limit, where,
                std::string("cannot start a process for the STEP importer (") + std::strerror(errno) +
                    "); close other programs or raise the limit on processes");
  }
  int fd_ = -1;
  pid_t pid_ = -1;
  std::optional<int> status_;
};

enum class Ending { closed, timeout, stopped };

/// Collects what the child writes until it closes the pipe, time is up, or it is told to stop.
Ending receive(int fd, const IsolationLimits& limits, std::string& bytes) {
  using Clock = std::chrono::steady_clock;
  const auto deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                           std::chrono::duration<double>(std::min(limits.timeout_s, 1e8)));
  std::string buffer(std::size_t{1} << 20, '\0');
  while (true) {
    if (limits.stop && limits.stop()) return Ending::stopped;
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    if (left <= 0) return Ending::timeout;
    pollfd ready{fd, POLLIN, 0};
    const int n = ::poll(&ready, 1, static_cast<int>(std::min<long long>(left + 1, 100)));
    if (n <= 0) continue;
    const ssize_t got = ::read(fd, buffer.data(), buffer.size());
    if (got > 0) bytes.append(buffer, 0, static_cast<std::size_t>(got));
    if (got == 0 || (got < 0 && errno != EINTR && errno != EAGAIN)) return Ending::closed;
  }
}

std::string signal_name(int signal) {
  switch (signal) {
    case SIGSEGV:
      return "segmentation fault";
    case SIGABRT:
      return "abort";
    case SIGFPE:
      return "arithmetic fault";
    case SIGBUS:
      return "bus error";
    case SIGILL:
      return "illegal instruction";
    case SIGKILL:
      return "killed, perhaps for want of memory";
    case SIGXCPU:
      return "CPU time limit";
    default:
      return ::strsignal(signal);
  }
}

std::string seconds(double s) {
  std::string text = std::to_string(s);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text + " s";
}

}  // namespace

std::string run_isolated(const std::string& where, const IsolationLimits& limits,
                         const std::function<std::string()>& work,
                         const std::function<std::string()>& diagnose) {
  Child child(where, limits, work);
  std::string bytes;
  const Ending ending = receive(child.fd(), limits, bytes);
  const auto limit_error = [&](const std::string& message) {
    return Error(ErrorCode::resource_limit, where, message);
  };
  const std::string reduce = "; export only the faces to lay on, or raise the limit";
  if (ending == Ending::stopped) throw limit_error("reading was interrupted; start it again");
  if (ending == Ending::timeout)
    throw limit_error("the STEP importer did not finish within " + seconds(limits.timeout_s) + reduce);
  const int status = child.wait();
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    if (signal == SIGINT || signal == SIGTERM || signal == SIGHUP)
      throw limit_error("reading was interrupted; start it again");
    if (signal == SIGXCPU)
      throw limit_error("the STEP importer did not finish within " + seconds(limits.timeout_s) +
                        " of CPU time" + reduce);
    const std::string reason = diagnose ? diagnose() : "";
    throw limit_error("the STEP importer died with signal " + std::to_string(signal) + " (" +
                      signal_name(signal) + ")" + (reason.empty() ? "" : ": " + reason) +
                      "; the file is damaged or too complex, export it again");
  }
  std::uint64_t size = 0;
  if (bytes.size() >= 9) std::memcpy(&size, bytes.data() + 1, sizeof size);
  if (bytes.size() < 9 || bytes.size() != 9 + size) {
    throw limit_error("the STEP importer ended without an answer (exit status " +
                      std::to_string(WEXITSTATUS(status)) + "); export the file again");
  }
  const Tag tag = static_cast<Tag>(bytes[0]);
  bytes.erase(0, 9);
  switch (tag) {
    case Tag::result:
      return bytes;
    case Tag::error:
      throw_packed_error(bytes, where);
    case Tag::out_of_memory:
      throw limit_error("the STEP importer needs more than " + std::to_string(limits.memory_bytes >> 20) +
                        " MiB of memory" + reduce);
    case Tag::unknown:
      break;
  }
  throw Error(ErrorCode::bad_input, where, "the STEP importer failed (" + bytes + "); export the file again");
}

}  // namespace afptraj::step
