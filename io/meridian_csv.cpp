#include "io/meridian_csv.h"

#include "geometry/error.h"
#include "io/csv_reader.h"
#include "io/number_text.h"
#include "io/text_file.h"

namespace afptraj {

Meridian read_meridian(const std::string& path) {
  constexpr std::size_t most_rows = 100000;
  const CsvTable table = read_csv_table(path, {{"z", "r"}, {}}, most_rows);
  std::vector<MeridianRow> rows;
  for (const CsvRow& row : table.rows) {
    const auto number = [&](std::size_t column, const char* name) {
      const auto value = parse_number(row.fields[column]);
      if (!value) {
        throw Error(ErrorCode::bad_input, file_line(path, row.line),
                    std::string(name) + " is '" + printable(row.fields[column]) + "'; write a number in mm");
      }
      return *value;
    };
    rows.push_back({number(0, "z"), number(1, "r")});
    if (rows.back().r_mm < 0) {
      throw Error(ErrorCode::bad_input, file_line(path, row.line),
                  "r is negative; give the distance from the axis");
    }
  }
  try {
    return meridian_through(rows);
  } catch (const Error& e) {
    throw Error(e.code(), path, e.what());
  }
}

}  // namespace afptraj
