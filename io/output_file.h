#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

namespace afptraj {

/// Checks, before any work is done, that a file can be written at `target`, and says where it will really be.
/// Throws Error(cannot_write) when the parent directory is missing or not writable, `target` is one of
/// `inputs`, a directory or a device, or when it exists and `replace` is not given.
std::filesystem::path check_output_file(const std::filesystem::path& target, bool replace,
                                        const std::vector<std::filesystem::path>& inputs);

/// A file that appears whole or not at all: written piece by piece under a hidden name beside its place,
/// flushed, and put there by one rename. Until then an older file stays as it is.
class OutputFile {
 public:
  /// Throws Error(cannot_write).
  OutputFile(const std::filesystem::path& target, bool replace,
             const std::vector<std::filesystem::path>& inputs = {});
  /// Removes what was written unless commit() was reached.
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// Throws Error(cannot_write), with what to do when the disk is full.
  void write(std::string_view piece);
  void commit();

 private:
  std::filesystem::path target_, staging_;
  bool replace_ = false;
  int fd_ = -1;
};

}  // namespace afptraj
