#pragma once

#include <stdexcept>
#include <string>

namespace afptraj {

/// What is wrong outside the program, as the exit codes of the command line (README.md, "Exit codes").
enum class ErrorCode {
  usage = 2,           ///< command line or job file
  bad_input = 3,       ///< a file that is read
  no_path = 4,         ///< no feasible path on this skin with these points
  cannot_write = 5,    ///< the result cannot be written
  resource_limit = 6,  ///< memory, time, or the STEP importer crashed
  internal = 70,       ///< a bug in afptraj
};

/// The one exception of afptraj: something outside the program is wrong.
/// `where` names the thing ("plies.csv:12", "part.step:#417", "--face"), `what()` says what is
/// wrong and what to do about it. Outcomes of geometry are never errors: they are values.
class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, std::string where, const std::string& message)
      : std::runtime_error(message), code_(code), where_(std::move(where)) {}
  ErrorCode code() const { return code_; }
  const std::string& where() const { return where_; }

 private:
  ErrorCode code_;
  std::string where_;
};

}  // namespace afptraj
