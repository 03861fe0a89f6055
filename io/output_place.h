#pragma once

#include <filesystem>
#include <string>

namespace afptraj {

/// Throws Error(cannot_write, path, message).
[[noreturn]] void cannot_write(const std::filesystem::path& path, const std::string& message);

/// What an errno of a write means for the user, and what to do.
std::string write_problem(int number);

/// An output's place with links followed and without trailing slashes. Throws Error(cannot_write) when its
/// parent directory does not exist.
std::filesystem::path resolve_output(const std::filesystem::path& target);

/// Flushes the entries of a directory, as far as the file system can.
void flush_directory(const std::filesystem::path& path);

}  // namespace afptraj
