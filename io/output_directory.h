#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "io/text_sink.h"

namespace afptraj {

/// Checks, before any work is done, that a result can go to `target`, and says where it will really
/// be (symbolic links followed). Throws Error(cannot_write) when
/// the parent directory is missing or not writable, `target` is a file, a dangling link, the current
/// directory, or a directory that holds something and `force` is not given; with `force` when it
/// holds anything that afptraj did not write; or when one of `inputs` is, or lies in, `target`.
std::filesystem::path check_output(const std::filesystem::path& target, bool force,
                                   const std::vector<std::filesystem::path>& inputs);

/// A result directory that appears whole or not at all.
///
/// Files are written into a hidden sibling directory, flushed, and put into place by one rename
/// (with `force` by an exchange with the old directory): whoever looks, or a run that is killed at any
/// moment, finds the old result or the new one. The sibling is locked while it is in use; siblings
/// left by killed runs are removed by the next one.
class OutputDirectory {
 public:
  /// Makes the sibling. Throws Error(cannot_write).
  OutputDirectory(std::filesystem::path target, bool force,
                  const std::vector<std::filesystem::path>& inputs = {});
  /// Removes the sibling unless commit() was reached.
  ~OutputDirectory();
  OutputDirectory(const OutputDirectory&) = delete;
  OutputDirectory& operator=(const OutputDirectory&) = delete;

  /// Where files are written until commit().
  const std::filesystem::path& staging() const { return staging_; }
  const std::filesystem::path& target() const { return target_; }

  /// Writes a file whole and flushes it. `name` is one of result_file_names().
  /// Throws Error(cannot_write), with what to do when the disk is full.
  void write(const std::string& name, std::string_view content);
  /// The same, of content that comes in parts: `produce` hands them on.
  void write(const std::string& name, const std::function<void(const TextSink&)>& produce);
  /// Flushes a file that something else has written to staging().
  void adopt(const std::string& name);

  /// Puts the result into place. Throws Error(cannot_write); the old result stays then.
  void commit();

 private:
  void remove_leftovers() const;
  void make_staging();

  std::filesystem::path target_, staging_;
  bool force_ = false;
  bool committed_ = false;
  int lock_ = -1;
};

/// The names a result can hold; only these are ever replaced.
const std::vector<std::string>& result_file_names();

}  // namespace afptraj
