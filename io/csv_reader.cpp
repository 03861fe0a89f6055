#include "io/csv_reader.h"

#include <algorithm>
#include <cctype>
#include <string_view>

#include "geometry/error.h"
#include "io/nearest_name.h"
#include "io/text_file.h"

namespace afptraj {
namespace {

constexpr std::size_t limit_bytes = 500000000;

[[noreturn]] void bad(const std::string& path, int line, const std::string& message) {
  throw Error(ErrorCode::bad_input, file_line(path, line), message);
}

// Splits text into records. Keeps the line number, so that every message can name it.
class Records {
 public:
  Records(const std::string& path, std::string_view text) : path_(path), text_(text) {}

  // The next record that is neither blank nor a comment; false at the end.
  bool next(CsvRow& row) {
    while (at_ < text_.size()) {
      if (skips_line()) continue;
      row.line = line_;
      row.fields.clear();
      while (field(row.fields)) {
      }
      return true;
    }
    return false;
  }

 private:
  bool at_line_end() const { return at_ == text_.size() || text_[at_] == '\n' || text_[at_] == '\r'; }

  void pass_line_end() {
    if (at_ == text_.size()) return;
    at_ += text_[at_] == '\r' && at_ + 1 < text_.size() && text_[at_ + 1] == '\n' ? 2 : 1;
    ++line_;
  }

  // Passes over a blank line or a comment.
  bool skips_line() {
    std::size_t look = at_;
    while (look < text_.size() && (text_[look] == ' ' || text_[look] == '\t')) ++look;
    if (look < text_.size() && text_[look] != '\n' && text_[look] != '\r' && text_[look] != '#') return false;
    at_ = look;
    while (!at_line_end()) ++at_;
    pass_line_end();
    return true;
  }

  // Reads one field; true when a further one follows in the record.
  bool field(std::vector<std::string>& fields) {
    fields.push_back(at_ < text_.size() && text_[at_] == '"' ? quoted(fields.size() + 1)
                                                             : plain(fields.size() + 1));
    if (at_line_end()) {
      pass_line_end();
      return false;
    }
    ++at_;  // the comma
    return true;
  }

  std::string plain(std::size_t number) {
    const std::size_t from = at_;
    while (!at_line_end() && text_[at_] != ',') {
      if (text_[at_] == '"') {
        bad(path_, line_,
            "field " + std::to_string(number) +
                " has a quote inside; put the whole field in quotes and double the inner one");
      }
      ++at_;
    }
    return std::string(text_.substr(from, at_ - from));
  }

  std::string quoted(std::size_t number) {
    const int opened = line_;
    std::string value;
    for (++at_;;) {
      if (at_ == text_.size())
        bad(path_, opened,
            "field " + std::to_string(number) + " opens a quote that is never closed; close it");
      const char c = text_[at_];
      if (c == '"') {
        ++at_;
        if (at_ == text_.size() || text_[at_] != '"') break;
        value += '"';
        ++at_;
      } else if (c == '\n' || c == '\r') {
        value += '\n';
        pass_line_end();
      } else {
        value += c;
        ++at_;
      }
    }
    if (!at_line_end() && text_[at_] != ',') {
      bad(path_, line_,
          "field " + std::to_string(number) +
              " goes on after its closing quote; double a quote inside a quoted field");
    }
    return value;
  }

  const std::string& path_;
  std::string_view text_;
  std::size_t at_ = 0;
  int line_ = 1;
};

std::string normalised(std::string_view name) {
  while (!name.empty() && std::isspace(static_cast<unsigned char>(name.front())) != 0) name.remove_prefix(1);
  while (!name.empty() && std::isspace(static_cast<unsigned char>(name.back())) != 0) name.remove_suffix(1);
  std::string out(name);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ",") + name;
  return text;
}

// A header in one field betrays another separator.
void refuse_other_separator(const std::string& path, const CsvRow& header) {
  if (header.fields.size() != 1) return;
  for (const auto& [separator, name] :
       {std::pair{';', "semicolons"}, std::pair{'\t', "tabs"}, std::pair{'|', "bars"}}) {
    if (header.fields[0].find(separator) != std::string::npos) {
      bad(path, header.line,
          std::string("columns are separated by ") + name +
              "; save the table with commas, and with decimal points in numbers");
    }
  }
}

// For each column asked for its place in the file, -1 for an optional one that is absent.
std::vector<int> match_columns(const std::string& path, const CsvRow& header, const CsvColumns& columns,
                               std::vector<std::string>& warnings) {
  std::vector<std::string> found;
  for (const std::string& field : header.fields) found.push_back(normalised(field));
  std::vector<std::string> wanted = columns.required;
  wanted.insert(wanted.end(), columns.optional.begin(), columns.optional.end());

  for (std::size_t i = 0; i < found.size(); ++i) {
    const std::string number = std::to_string(i + 1);
    if (found[i].empty()) bad(path, header.line, "column " + number + " has no name; name or remove it");
    if (std::find(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(i), found[i]) !=
        found.begin() + static_cast<std::ptrdiff_t>(i)) {
      bad(path, header.line, "column '" + printable(found[i]) + "' stands twice in the header; keep one");
    }
  }
  std::vector<std::string> unused;
  for (const std::string& name : found) {
    if (std::find(wanted.begin(), wanted.end(), name) == wanted.end()) unused.push_back(name);
  }
  std::vector<int> place;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const auto at = std::find(found.begin(), found.end(), wanted[i]);
    if (at == found.end() && i < columns.required.size()) {
      const std::string nearest = nearest_name(wanted[i], unused);
      bad(path, header.line,
          "column '" + wanted[i] + "' is missing: the header has " + printable(joined(found), 120) + "; " +
              (nearest.empty() ? "the header must name " + joined(columns.required)
                               : "rename '" + printable(nearest) + "' to '" + wanted[i] + "'"));
    }
    place.push_back(at == found.end() ? -1 : static_cast<int>(at - found.begin()));
  }
  for (const std::string& name : unused) {
    warnings.push_back("column '" + printable(name) + "' is not used" + did_you_mean(name, columns.optional));
  }
  return place;
}

void require_width(const std::string& path, const CsvRow& row, std::size_t width) {
  if (row.fields.size() == width) return;
  const bool longer = row.fields.size() > width;
  bad(path, row.line,
      "the row has " + std::to_string(row.fields.size()) + " fields, the header " + std::to_string(width) +
          "; " +
          (longer ? "remove the surplus (a decimal comma also splits a field: write 12.5, not 12,5)"
                  : "add the missing ones"));
}

}  // namespace

CsvTable read_csv_table(const std::string& path, const CsvColumns& columns, std::size_t limit_rows) {
  const std::string text = read_text_file(path, limit_bytes);
  Records records(path, text);
  CsvRow header;
  if (!records.next(header)) {
    throw Error(ErrorCode::bad_input, path,
                "is empty; the first line must name the columns " + joined(columns.required));
  }
  refuse_other_separator(path, header);

  CsvTable table;
  const std::vector<int> place = match_columns(path, header, columns, table.warnings);
  CsvRow row;
  while (records.next(row)) {
    require_width(path, row, header.fields.size());
    if (table.rows.size() == limit_rows) {
      throw Error(ErrorCode::resource_limit, file_line(path, row.line),
                  "the table has more than " + std::to_string(limit_rows) + " rows; split it");
    }
    CsvRow ordered{row.line, {}};
    for (const int at : place) {
      ordered.fields.push_back(at < 0 ? std::string() : row.fields[static_cast<std::size_t>(at)]);
    }
    table.rows.push_back(std::move(ordered));
  }
  if (table.rows.empty())
    throw Error(ErrorCode::bad_input, path, "has a header but no rows; add at least one");
  return table;
}

}  // namespace afptraj
