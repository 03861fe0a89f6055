#pragma once

#include <string>
#include <vector>

namespace afptraj::cli {

/// Thrown when whoever reads stdout has gone: the program ends without a word.
struct ReaderGone {};

/// Writes data to stdout. Throws ReaderGone, or Error(cannot_write) when it cannot be written.
void print(const std::string& text);

/// Writes "afptraj: <where>: <message>" as one line to stderr, control characters escaped.
void print_error(const std::string& where, const std::string& message);
void print_warning(const std::string& where, const std::string& message);
/// Writes a line to stderr.
void print_note(const std::string& message);

/// A progress bar on stderr: only on a terminal, gone when it is destroyed. Colour is left out
/// when NO_COLOR is set.
class ProgressBar {
 public:
  explicit ProgressBar(bool wanted);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;
  void show(const std::string& stage, double done);

 private:
  bool shown_ = false, active_ = false, colour_ = false;
  int last_percent_ = -1;
  std::string last_stage_;
};

/// Columns of text, aligned; numbers to the right.
class Table {
 public:
  explicit Table(std::vector<std::string> header, std::vector<bool> right);
  void add(std::vector<std::string> row);
  std::string text() const;

 private:
  std::vector<std::vector<std::string>> rows_;
  std::vector<bool> right_;
};

/// A number for people, to `digits` significant digits, without an exponent where that stays short.
std::string short_number(double x, int digits = 4);

}  // namespace afptraj::cli
