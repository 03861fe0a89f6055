#pragma once

#include <string>
#include <vector>

namespace afptraj {

/// One record: the fields in the order asked for, and the line it begins on.
struct CsvRow {
  int line = 0;
  std::vector<std::string> fields;
};

/// Which columns a table must and may have. Names are compared without regard to case.
struct CsvColumns {
  std::vector<std::string> required;
  std::vector<std::string> optional;
};

/// A table with its fields in the order required columns, optional columns; an optional column
/// that the file does not have gives empty fields.
struct CsvTable {
  std::vector<CsvRow> rows;
  std::vector<std::string> warnings;  ///< columns that are not used, whole messages without the file name
};

/// Reads a comma-separated table with a header: RFC 4180, UTF-8 (a byte order mark is skipped), line
/// ends LF, CRLF or CR, quoted fields with doubled quotes and line ends inside, blank lines and lines
/// that begin with '#' passed over.
/// Throws Error(bad_input, "file:line", ...) for every defect, Error(resource_limit) beyond
/// `limit_rows` rows.
CsvTable read_csv_table(const std::string& path, const CsvColumns& columns, std::size_t limit_rows = 1000000);

}  // namespace afptraj
