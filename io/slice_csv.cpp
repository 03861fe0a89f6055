#include "io/slice_csv.h"

#include <cmath>
#include <optional>
#include <unordered_set>

#include "geometry/error.h"
#include "io/csv_reader.h"
#include "io/number_text.h"
#include "io/text_file.h"

namespace afptraj {
namespace {

constexpr std::size_t most_rows = 5000000;
enum Column : std::size_t { ring_column, index_column, x_column, y_column, z_column, closed_column };
const char* const names[] = {"path", "i", "x", "y", "z", "closed"};

}  // namespace

SliceFile read_slice(const std::string& path) {
  CsvTable table = read_csv_table(path, {{"path", "i", "x", "y"}, {"z", "closed"}}, most_rows);
  std::vector<InputRing> rings;
  std::unordered_set<std::string> known;
  std::optional<double> z;
  double last_index = 0;
  for (const CsvRow& row : table.rows) {
    const auto bad = [&](const std::string& message) {
      throw Error(ErrorCode::bad_input, file_line(path, row.line), message);
    };
    const auto number = [&](Column column) {
      const auto value = parse_number(row.fields[column]);
      if (!value) {
        bad(std::string("column '") + names[column] + "': '" + printable(row.fields[column]) +
            "' is not a finite number; write it like 12.5");
      }
      return *value;
    };
    const std::string& name = row.fields[ring_column];
    if (rings.empty() || rings.back().name != name) {
      if (name.find_first_not_of(" \t\n") == std::string::npos) bad("column 'path': is empty; name the ring");
      if (!known.insert(name).second)
        bad("ring '" + printable(name) + "' appears again after another; keep the rows of a ring together");
      rings.push_back({name, {}, {}});
      last_index = -HUGE_VAL;
    }
    const double index = number(index_column);
    if (index <= last_index)
      bad("column 'i': " + printable(row.fields[index_column]) +
          " does not come after the row before; number the points of a ring upwards");
    last_index = index;
    if (row.fields[closed_column] == "0")
      bad("ring '" + printable(name) + "' is open; a slice needs closed rings");
    if (!row.fields[z_column].empty()) {
      const double at = number(z_column);
      if (z && *z != at) bad("column 'z': differs from the rows before; a slice is planar, give one height");
      z = at;
    }
    rings.back().points.emplace_back(number(x_column), number(y_column));
    rings.back().lines.push_back(row.line);
  }
  for (InputRing& ring : rings) ring.name = printable(ring.name);
  return {Slice(path, rings), z.value_or(0), std::move(table.warnings)};
}

}  // namespace afptraj
