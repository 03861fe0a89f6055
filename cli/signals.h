#pragma once

namespace afptraj::cli {

/// Opens /dev/null for standard streams that the caller has closed, ignores SIGPIPE and SIGXFSZ
/// (writes then fail with their reason), and lets SIGINT and SIGTERM ask for a stop. A second one
/// ends the program at once; so does a stop that is not followed within some seconds.
void install_signal_handlers();

/// Lets a stop be asked for after `seconds`.
void set_timeout(double seconds);

/// The signal that asked for a stop: 0 none, SIGINT, SIGTERM, or SIGALRM for the timeout.
int stop_signal();

/// The exit code that goes with it.
int exit_code_of_stop(int signal);

}  // namespace afptraj::cli
