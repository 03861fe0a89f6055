#include <csignal>
#include <new>
#include <stdexcept>

#include "cli/arguments.h"
#include "cli/build_facts.h"
#include "cli/commands.h"
#include "cli/part_file.h"
#include "cli/signals.h"
#include "cli/terminal.h"
#include "geometry/error.h"

namespace afptraj::cli {
namespace {

int dispatch(const Arguments& arguments) {
  if (arguments.timeout_s > 0) set_timeout(arguments.timeout_s);
  switch (arguments.command) {
    case Arguments::Command::version:
      print(std::string("afptraj ") + version() + "\n");
      return 0;
    case Arguments::Command::run:
      return run(arguments);
    case Arguments::Command::inspect:
      return inspect(arguments);
    case Arguments::Command::wind:
      return wind(arguments);
    case Arguments::Command::fill:
      return fill(arguments);
    case Arguments::Command::doctor:
      return doctor(arguments);
    case Arguments::Command::help:
    case Arguments::Command::none:
      break;
  }
  print(arguments.help);
  return 0;
}

int report_stop() {
  const int signal = stop_signal();
  const char* message = signal == SIGALRM
                            ? "time is up (--timeout); nothing was written, give more time or a larger --step"
                        : signal == SIGINT ? "interrupted; nothing was written"
                                           : "terminated; nothing was written";
  print_error("stopped", message);
  return exit_code_of_stop(signal);
}

// The one place where outcomes become exit codes (README.md, "Exit codes").
int guarded(int count, const char* const* words) {
  try {
    return dispatch(parse_arguments(count, words));
  } catch (const Error& e) {
    print_error(e.where(), e.what());
    return static_cast<int>(e.code());
  } catch (const Stopped&) {
    return report_stop();
  } catch (const ReaderGone&) {
    return 0;
  } catch (const std::bad_alloc&) {
    print_error("memory",
                "is used up; close other programs, raise the limit (ulimit -v) or use a larger --step");
    return static_cast<int>(ErrorCode::resource_limit);
  } catch (const std::exception& e) {
    print_error("internal error",
                std::string(e.what()) + "; this is a bug in afptraj, please report it with the input files");
    return static_cast<int>(ErrorCode::internal);
  }
}

}  // namespace
}  // namespace afptraj::cli

int main(int argc, char** argv) {
  afptraj::cli::install_signal_handlers();
  return afptraj::cli::guarded(argc, argv);
}
