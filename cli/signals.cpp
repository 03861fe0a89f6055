#include "cli/signals.h"

#include <fcntl.h>
#include <sys/time.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <csignal>

#include "geometry/error.h"

namespace afptraj::cli {
namespace {

std::atomic<int> stop{0};
static_assert(std::atomic<int>::is_always_lock_free);

constexpr unsigned patience_s = 5;  // from a stop asked for to the end by force

void on_signal(int signal) {
  const int earlier = stop.load();
  if (earlier != 0) ::_exit(exit_code_of_stop(signal == SIGALRM ? earlier : signal));
  stop.store(signal);
  ::alarm(patience_s);
}

}  // namespace

void install_signal_handlers() {
  for (int fd = 0; fd <= 2; ++fd) {
    if (::fcntl(fd, F_GETFD) < 0) static_cast<void>(::open("/dev/null", fd == 0 ? O_RDONLY : O_WRONLY));
  }
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  struct sigaction action {};
  action.sa_handler = on_signal;
  sigemptyset(&action.sa_mask);
  action.sa_flags = 0;  // no SA_RESTART: a wait ends and the stop is seen
  for (const int signal : {SIGINT, SIGTERM, SIGALRM}) {
    struct sigaction old {};
    ::sigaction(signal, nullptr, &old);
    if (old.sa_handler == SIG_IGN && signal == SIGINT) continue;  // a background job of a shell script
    ::sigaction(signal, &action, nullptr);
  }
}

void set_timeout(double seconds) {
  itimerval timer{};
  timer.it_value.tv_sec = static_cast<time_t>(seconds);
  timer.it_value.tv_usec = static_cast<suseconds_t>((seconds - std::floor(seconds)) * 1e6);
  ::setitimer(ITIMER_REAL, &timer, nullptr);
}

int stop_signal() { return stop.load(); }

int exit_code_of_stop(int signal) {
  return signal == SIGALRM ? static_cast<int>(ErrorCode::resource_limit) : 128 + signal;
}

}  // namespace afptraj::cli
