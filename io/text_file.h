#pragma once

#include <cstddef>
#include <string>

#include "geometry/error.h"

namespace afptraj {

/// What Error::where holds for a place in a file: "plies.csv:12".
std::string file_line(const std::string& path, int line);

/// `text` on one line for people: control characters and line ends become escapes, long text is cut.
std::string printable(const std::string& text, std::size_t longest = 60);

/// Says that the file is missing, a directory, a device or pipe, or not readable:
/// Error(`code`, path, ...); nothing when it is a readable regular file.
void require_readable_file(const std::string& path, ErrorCode code = ErrorCode::bad_input);

/// The whole of a regular file, as it is. Throws Error(`code`) as above, and
/// Error(resource_limit) when it is larger than `limit_bytes`.
std::string read_file(const std::string& path, std::size_t limit_bytes,
                      ErrorCode code = ErrorCode::bad_input);

/// The text of a UTF-8 file without a byte order mark. Throws Error(`code`) naming the line for what
/// is not text: UTF-16, NUL bytes, invalid UTF-8, and well-known binary formats by their name.
std::string read_text_file(const std::string& path, std::size_t limit_bytes,
                           ErrorCode code = ErrorCode::bad_input);

}  // namespace afptraj
