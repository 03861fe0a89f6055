#include "cli/terminal.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "geometry/error.h"
#include "io/text_file.h"

namespace afptraj::cli {
namespace {

constexpr std::size_t longest_message = 4000;

// 0, or the errno of what went wrong.
int write_all(int fd, const std::string& text) {
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t n = ::write(fd, text.data() + done, text.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return errno;
    done += static_cast<std::size_t>(n);
  }
  return 0;
}

void print_line(const std::string& text) {
  // where stderr itself cannot be written there is nobody to tell
  static_cast<void>(write_all(STDERR_FILENO, printable(text, longest_message) + "\n"));
}

// Letters, not bytes, of UTF-8 text.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

}  // namespace

void print(const std::string& text) {
  const int problem = write_all(STDOUT_FILENO, text);
  if (problem == EPIPE) throw ReaderGone{};
  if (problem != 0) {
    throw Error(ErrorCode::cannot_write, "stdout",
                std::string(std::strerror(problem)) + "; send the output elsewhere");
  }
}

void print_error(const std::string& where, const std::string& message) {
  print_line("afptraj: " + where + ": " + message);
}

void print_warning(const std::string& where, const std::string& message) {
  print_line("afptraj: warning: " + where + ": " + message);
}

void print_note(const std::string& message) { print_line(message); }

ProgressBar::ProgressBar(bool wanted) {
  const char* terminal = std::getenv("TERM");
  active_ =
      wanted && ::isatty(STDERR_FILENO) == 1 && terminal != nullptr && std::strcmp(terminal, "dumb") != 0;
  const char* no_colour = std::getenv("NO_COLOR");
  colour_ = no_colour == nullptr || *no_colour == '\0';
}

ProgressBar::~ProgressBar() {
  if (shown_) static_cast<void>(write_all(STDERR_FILENO, "\r\x1b[K"));
}

void ProgressBar::show(const std::string& stage, double done) {
  if (!active_) return;
  const int percent = static_cast<int>(std::lround(100 * std::clamp(done, 0.0, 1.0)));
  if (percent == last_percent_ && stage == last_stage_) return;
  last_percent_ = percent;
  last_stage_ = stage;
  constexpr int cells = 30;
  const int full = percent * cells / 100;
  std::string bar = std::string(static_cast<std::size_t>(full), '#') +
                    std::string(static_cast<std::size_t>(cells - full), '.');
  if (colour_) bar = "\x1b[36m" + bar + "\x1b[0m";
  static_cast<void>(write_all(
      STDERR_FILENO, "\r[" + bar + "] " + std::to_string(percent) + " % " + printable(stage, 40) + "\x1b[K"));
  shown_ = true;
}

Table::Table(std::vector<std::string> header, std::vector<bool> right)
    : rows_{std::move(header)}, right_(std::move(right)) {}

void Table::add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }

std::string Table::text() const {
  std::vector<std::size_t> widths(right_.size(), 0);
  for (const auto& row : rows_) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], width(row[i]));
  }
  std::string out;
  for (const auto& row : rows_) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string space(widths[i] - width(row[i]), ' ');
      line += (i == 0 ? "" : "  ") + (right_[i] ? space + row[i] : row[i] + space);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    out += line + "\n";
  }
  return out;
}

std::string short_number(double x, int digits) {
  if (std::isnan(x)) return "?";
  if (std::isinf(x)) return x > 0 ? "inf" : "-inf";
  if (x == 0) return "0";
  char buffer[64];
  const double size = std::abs(x);
  if (size >= 1e-3 && size < 1e7) {
    const int decimals = std::max(0, digits - 1 - static_cast<int>(std::floor(std::log10(size))));
    std::snprintf(buffer, sizeof buffer, "%.*f", decimals, x);
    std::string text = buffer;
    if (text.find('.') != std::string::npos) {
      text.erase(text.find_last_not_of('0') + 1);
      if (text.back() == '.') text.pop_back();
    }
    return text;
  }
  std::snprintf(buffer, sizeof buffer, "%.*g", digits, x);
  return buffer;
}

}  // namespace afptraj::cli
