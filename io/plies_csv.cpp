#include "io/plies_csv.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_set>

#include "geometry/error.h"
#include "io/csv_reader.h"
#include "io/number_text.h"
#include "io/text_file.h"

namespace afptraj {
namespace {

constexpr double greatest_coordinate_mm = 1e7;  // ten kilometres: beyond it a double loses 1e-9 mm
constexpr double greatest_direction = 1e100;    // its square is still a number
constexpr double least_direction = 1e-100;
constexpr std::size_t greatest_plies = 10000;

const std::array<const char*, 8> column_names{"ply", "x", "y", "z", "dx", "dy", "dz", "start"};

class RowReader {
 public:
  RowReader(const std::string& path, const CsvRow& row) : path_(path), row_(row) {}

  [[noreturn]] void bad(std::size_t column, const std::string& message) const {
    throw Error(ErrorCode::bad_input, file_line(path_, row_.line),
                std::string("column '") + column_names[column] + "': " + message);
  }
  [[noreturn]] void bad_row(const std::string& message) const {
    throw Error(ErrorCode::bad_input, file_line(path_, row_.line), message);
  }

  const std::string& text(std::size_t column) const { return row_.fields[column]; }

  double number(std::size_t column, double limit) const {
    const std::string& field = text(column);
    if (field.find_first_not_of(" \t") == std::string::npos) bad(column, "is empty; give a number");
    const auto value = parse_number(field);
    if (!value) bad(column, why_no_number(field));
    if (std::abs(*value) > limit) {
      bad(column, "'" + printable(field) + "' is out of range; it must lie between -" +
                      number_text(limit, 0) + " and " + number_text(limit, 0));
    }
    return *value;
  }

  bool starts() const {
    std::string field = text(7);
    std::erase_if(field, [](char c) { return c == ' ' || c == '\t'; });
    if (field.empty() || field == "0") return false;
    if (field == "1") return true;
    bad(7, "'" + printable(field) + "' is neither 0 nor 1; write 1 on the row where the ply starts");
  }

 private:
  static std::string why_no_number(const std::string& field) {
    const std::string shown = "'" + printable(field) + "'";
    if (std::count(field.begin(), field.end(), ',') == 1) {
      std::string fixed = field;
      std::replace(fixed.begin(), fixed.end(), ',', '.');
      if (parse_number(fixed)) return shown + " has a decimal comma; write " + printable(fixed);
    }
    std::string lower = field;
    for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    for (const char* word : {"nan", "inf"}) {
      if (lower.find(word) != std::string::npos) return shown + " is not a finite number; give a finite one";
    }
    // A number too large for a double is all digits, signs, a point and an exponent.
    if (field.find_first_not_of("+-.0123456789eE \t") == std::string::npos &&
        field.find_first_of("0123456789") != std::string::npos &&
        field.find_first_of("eE") != std::string::npos) {
      return shown + " is not a finite number; give a finite one";
    }
    return shown + " is not a number; write it like 12.5";
  }

  const std::string& path_;
  const CsvRow& row_;
};

PlyPoint read_point(const RowReader& row, int line) {
  PlyPoint point;
  point.line = line;
  for (std::size_t i = 0; i < 3; ++i) {
    point.position[static_cast<Eigen::Index>(i)] = row.number(1 + i, greatest_coordinate_mm);
    point.direction[static_cast<Eigen::Index>(i)] = row.number(4 + i, greatest_direction);
  }
  if (point.direction.norm() < least_direction) {
    row.bad_row("the direction (columns dx, dy, dz) is zero; give the fibre direction");
  }
  return point;
}

}  // namespace

PliesFile read_plies_file(const std::string& path) {
  CsvTable table = read_csv_table(path, {{"ply", "x", "y", "z", "dx", "dy", "dz"}, {"start"}});
  PliesFile file;
  file.warnings = std::move(table.warnings);
  std::unordered_set<std::string> names;
  int start_line = 0;
  for (const CsvRow& fields : table.rows) {
    const RowReader row(path, fields);
    const std::string& name = row.text(0);
    if (name.find_first_not_of(" \t\n") == std::string::npos) row.bad(0, "is empty; name the ply");
    if (file.plies.empty() || file.plies.back().name != name) {
      if (!names.insert(name).second) {
        row.bad(0, "ply '" + printable(name) + "' appears again after ply '" +
                       printable(file.plies.back().name) +
                       "'; keep the rows of a ply together, or give it another name");
      }
      if (file.plies.size() == greatest_plies) {
        throw Error(ErrorCode::resource_limit, file_line(path, fields.line),
                    "the file has more than " + std::to_string(greatest_plies) + " plies; split it");
      }
      file.plies.push_back({name, {}, 0});
      start_line = 0;
    }
    PlyOrientation& ply = file.plies.back();
    ply.points.push_back(read_point(row, fields.line));
    if (row.starts()) {
      if (start_line != 0) {
        row.bad(7, "ply '" + printable(name) + "' has its start on line " + std::to_string(start_line) +
                       " already; keep one");
      }
      start_line = fields.line;
      ply.start = ply.points.size() - 1;
    }
  }
  return file;
}

std::vector<PlyOrientation> read_plies(const std::string& path) { return read_plies_file(path).plies; }

}  // namespace afptraj
