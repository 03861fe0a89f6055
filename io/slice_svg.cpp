#include "io/slice_svg.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "geometry/error.h"
#include "io/flat_curve.h"
#include "io/number_text.h"
#include "io/text_file.h"

namespace afptraj {
namespace {

constexpr std::size_t most_bytes = std::size_t{256} << 20;

using Affine = Eigen::Affine2d;

struct Tag {
  std::string name;
  std::map<std::string, std::string> attributes;
  bool closes = false, empty = false;
  int line = 1;
};

// Numbers and letters of attributes.
class Scanner {
 public:
  explicit Scanner(const std::string& text) : text_(text) {}
  void skip() {
    while (at_ < text_.size() &&
           (std::isspace(static_cast<unsigned char>(text_[at_])) != 0 || text_[at_] == ','))
      ++at_;
  }
  bool done() {
    skip();
    return at_ >= text_.size();
  }
  char peek() {
    skip();
    return at_ < text_.size() ? text_[at_] : '\0';
  }
  char take() {
    const char c = peek();
    ++at_;
    return c;
  }
  std::optional<double> number() {
    skip();
    std::size_t i = at_;
    const auto digits = [&] {
      const std::size_t start = i;
      while (i < text_.size() && text_[i] >= '0' && text_[i] <= '9') ++i;
      return i - start;
    };
    if (i < text_.size() && (text_[i] == '+' || text_[i] == '-')) ++i;
    std::size_t count = digits();
    if (i < text_.size() && text_[i] == '.') {
      ++i;
      count += digits();
    }
    if (count == 0) return std::nullopt;
    if (i < text_.size() && (text_[i] == 'e' || text_[i] == 'E')) {
      const std::size_t back = i++;
      if (i < text_.size() && (text_[i] == '+' || text_[i] == '-')) ++i;
      if (digits() == 0) i = back;
    }
    const auto value = parse_number(std::string_view(text_).substr(at_, i - at_));
    at_ = i;
    return value;
  }
  std::optional<bool> flag() {
    const char c = peek();
    if (c != '0' && c != '1') return std::nullopt;
    ++at_;
    return c == '1';
  }
  std::string word() {
    skip();
    std::string out;
    while (at_ < text_.size() && std::isalpha(static_cast<unsigned char>(text_[at_])) != 0)
      out += text_[at_++];
    return out;
  }

 private:
  const std::string& text_;
  std::size_t at_ = 0;
};

class Reader {
 public:
  Reader(const std::string& path, double tolerance)
      : path_(path), text_(read_text_file(path, most_bytes)), tolerance_(tolerance) {}

  SliceFile read() {
    struct Level {
      std::string name;
      Affine transform;
      bool hidden;
    };
    std::vector<Level> levels{{"", Affine::Identity(), false}};
    static const std::set<std::string> hides{
        "defs",  "clipPath", "mask",  "symbol", "pattern",        "marker",         "metadata",
        "style", "script",   "title", "desc",   "linearGradient", "radialGradient", "filter"};
    bool drawing = false;
    while (auto tag = next()) {
      if (tag->closes) {
        if (levels.size() < 2 || levels.back().name != tag->name)
          bad(tag->line, "'</" + printable(tag->name) + ">' closes what is not open; write well-formed XML");
        levels.pop_back();
        continue;
      }
      Level level{tag->name, levels.back().transform, levels.back().hidden || hides.count(tag->name) > 0};
      if (tag->name == "svg" && !drawing) {
        drawing = true;
        level.transform = view(*tag);
      } else if (!drawing) {
        bad(tag->line, "is no SVG drawing: its first element is '" + printable(tag->name) +
                           "'; give a file with an svg element");
      }
      if (tag->attributes.count("transform") > 0)
        level.transform = level.transform * transform(*tag, tag->attributes["transform"]);
      if (!level.hidden) shape(*tag, level.transform);
      if (!tag->empty) levels.push_back(std::move(level));
    }
    if (!drawing) bad(0, "is no SVG drawing; give a file with an svg element");
    if (levels.size() > 1)
      bad(line_, "ends within '" + printable(levels.back().name) + "'; write well-formed XML");
    for (const auto& [name, count] : left_out_)
      warnings_.push_back(std::to_string(count) + " '" + name +
                          "' left out: a slice is made of closed shapes");
    return {Slice(path_, rings_), 0, warnings_};
  }

 private:
  [[noreturn]] void bad(int line, const std::string& message) const {
    throw Error(ErrorCode::bad_input, line > 0 ? file_line(path_, line) : path_, message);
  }

  void advance(std::size_t to) {
    to = std::min(to, text_.size());
    line_ += static_cast<int>(std::count(text_.begin() + static_cast<std::ptrdiff_t>(at_),
                                         text_.begin() + static_cast<std::ptrdiff_t>(to), '\n'));
    at_ = to;
  }
  bool starts(const char* what) const { return text_.compare(at_, std::string_view(what).size(), what) == 0; }
  void pass(const char* end) {
    const std::size_t found = text_.find(end, at_);
    if (found == std::string::npos) bad(line_, "a comment or declaration has no end; write well-formed XML");
    advance(found + std::string_view(end).size());
  }

  std::optional<Tag> next() {
    for (;;) {
      const std::size_t open = text_.find('<', at_);
      advance(open);
      if (open == std::string::npos) return std::nullopt;
      if (starts("<!--")) {
        pass("-->");
      } else if (starts("<![CDATA[")) {
        pass("]]>");
      } else if (starts("<?")) {
        pass("?>");
      } else if (starts("<!")) {
        // a document type may hold declarations in brackets
        const std::size_t close = text_.find('>', at_), bracket = text_.find('[', at_);
        pass(bracket < close ? "]>" : ">");
      } else {
        return tag();
      }
    }
  }

  Tag tag() {
    Tag out;
    out.line = line_;
    std::size_t i = at_ + 1;
    if (i < text_.size() && text_[i] == '/') out.closes = true, ++i;
    const auto blank = [&](char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; };
    const auto name = [&] {
      std::string word;
      while (i < text_.size() && !blank(text_[i]) && text_[i] != '=' && text_[i] != '>' && text_[i] != '/')
        word += text_[i++];
      const std::size_t colon = word.find(':');  // svg:path and path are one
      return colon == std::string::npos || word.compare(0, colon, "svg") != 0 ? word : word.substr(colon + 1);
    };
    const auto skip = [&] {
      while (i < text_.size() && blank(text_[i])) ++i;
    };
    out.name = name();
    for (;;) {
      skip();
      if (i >= text_.size())
        bad(out.line, "the element '" + printable(out.name) + "' has no end; write well-formed XML");
      if (text_[i] == '>') break;
      if (text_[i] == '/') {
        out.empty = true, ++i;
        continue;
      }
      const std::string key = name();
      skip();
      if (key.empty() || i >= text_.size() || text_[i] != '=')
        bad(out.line, "the element '" + printable(out.name) +
                          "' has an attribute without a value; write well-formed XML");
      ++i;
      skip();
      const char quote = i < text_.size() ? text_[i] : '\0';
      const std::size_t end = quote == '"' || quote == '\'' ? text_.find(quote, i + 1) : std::string::npos;
      if (end == std::string::npos)
        bad(out.line, "attribute '" + printable(key) + "' has no quoted value; write well-formed XML");
      out.attributes[key] = text_.substr(i + 1, end - i - 1);
      i = end + 1;
    }
    advance(i + 1);
    return out;
  }

  double number(const Tag& tag, const std::string& key,
                std::optional<double> otherwise = std::nullopt) const {
    const auto found = tag.attributes.find(key);
    if (found == tag.attributes.end()) {
      if (otherwise) return *otherwise;
      bad(tag.line, "'" + printable(tag.name) + "' needs the attribute '" + key + "'; give it");
    }
    Scanner scan(found->second);
    const auto value = scan.number();
    const std::string unit = value ? scan.word() : "";
    if (!value || !scan.done() || (unit != "" && unit != "px"))
      bad(tag.line, "attribute '" + key + "': '" + printable(found->second) +
                        "' is not a number of user units; write it like 12.5");
    return *value;
  }

  // From user units to millimetres, y upwards.
  Affine view(const Tag& tag) {
    std::optional<double> box[4];
    const auto found = tag.attributes.find("viewBox");
    if (found != tag.attributes.end()) {
      Scanner scan(found->second);
      for (auto& value : box) {
        if (!(value = scan.number()))
          bad(tag.line,
              "viewBox: '" + printable(found->second) + "' is not four numbers; write it like 0 0 100 50");
      }
      if (!(*box[2] > 0) || !(*box[3] > 0))
        bad(tag.line, "viewBox: is empty; give a width and height above 0");
    }
    static const std::map<std::string, double> units{{"mm", 1},         {"cm", 10},       {"in", 25.4},
                                                     {"pt", 25.4 / 72}, {"pc", 25.4 / 6}, {"px", 25.4 / 96}};
    const auto size = [&](const char* key) -> std::optional<double> {
      const auto text = tag.attributes.find(key);
      if (text == tag.attributes.end()) return std::nullopt;
      Scanner scan(text->second);
      const auto value = scan.number();
      const auto unit = units.find(scan.word());
      if (!value || unit == units.end()) return std::nullopt;
      return *value * unit->second;
    };
    const auto width = size("width"), height = size("height");
    double scale = 1;
    if (box[2] && width && *width > 0) {
      scale = *width / *box[2];
      if (height && std::abs(*height / *box[3] - scale) > 1e-6 * scale) {
        // the drawing keeps its shape within the page, as preserveAspectRatio has it by default
        scale = std::min(scale, *height / *box[3]);
      }
    } else {
      warnings_.push_back("has no width in mm and viewBox; one unit is taken for a millimetre");
    }
    // y is turned over within the view box
    const double turn = box[3] ? 2 * *box[1] + *box[3] : 0;
    Affine out = Affine::Identity();
    out.linear() << scale, 0, 0, -scale;
    out.translation() << 0, scale * turn;
    return out;
  }

  Affine transform(const Tag& tag, const std::string& text) const {
    Affine out = Affine::Identity();
    Scanner scan(text);
    while (!scan.done()) {
      const std::string word = scan.word();
      std::vector<double> v;
      const bool opened = scan.take() == '(';
      while (opened && scan.peek() != ')' && !scan.done()) {
        const auto value = scan.number();
        if (!value) break;
        v.push_back(*value);
      }
      Affine one = Affine::Identity();
      bool known = opened && scan.take() == ')';
      if (known && word == "translate" && (v.size() == 1 || v.size() == 2)) {
        one.translation() << v[0], v.size() > 1 ? v[1] : 0;
      } else if (known && word == "scale" && (v.size() == 1 || v.size() == 2)) {
        one.linear() << v[0], 0, 0, v.size() > 1 ? v[1] : v[0];
      } else if (known && word == "rotate" && (v.size() == 1 || v.size() == 3)) {
        const Vec2 about = v.size() == 3 ? Vec2(v[1], v[2]) : Vec2(0, 0);
        one =
            Eigen::Translation2d(about) * Eigen::Rotation2Dd(v[0] * pi / 180) * Eigen::Translation2d(-about);
      } else if (known && word == "matrix" && v.size() == 6) {
        one.linear() << v[0], v[2], v[1], v[3];
        one.translation() << v[4], v[5];
      } else if (known && (word == "skewX" || word == "skewY") && v.size() == 1) {
        one.linear()(word == "skewX" ? 0 : 1, word == "skewX" ? 1 : 0) = std::tan(v[0] * pi / 180);
      } else {
        bad(tag.line, "transform: '" + printable(text) +
                          "' cannot be read; write translate, scale, rotate, skewX, skewY or matrix");
      }
      out = out * one;
    }
    return out;
  }

  void add(const Tag& tag, const Affine& transform, std::vector<Vec2> points) {
    while (points.size() > 1 && (points.back() - points.front()).norm() <= 1e-9 * (1 + points.front().norm()))
      points.pop_back();
    if (points.size() < 2) return;  // a lone move
    InputRing ring{std::to_string(rings_.size()), {}, std::vector<int>(points.size(), tag.line)};
    for (const Vec2& p : points) ring.points.push_back(transform * p);
    rings_.push_back(std::move(ring));
  }

  void shape(const Tag& tag, const Affine& transform) {
    // curves are flattened in user units
    const double scale = std::max(transform.linear().norm() / std::sqrt(2.0), 1e-300),
                 tolerance = tolerance_ / (1.5 * scale);
    const auto oval = [&](double cx, double cy, double rx, double ry) {
      if (!(rx > 0) || !(ry > 0)) bad(tag.line, "'" + tag.name + "' has no size; give radii above 0");
      std::vector<Vec2> points;
      append_curve(
          points, [&](double t) { return Vec2(cx + rx * std::cos(t), cy + ry * std::sin(t)); }, 0, 2 * pi, 8,
          tolerance);
      add(tag, transform, std::move(points));
    };
    if (tag.name == "path") {
      const auto d = tag.attributes.find("d");
      if (d != tag.attributes.end()) path(tag, d->second, transform, tolerance);
    } else if (tag.name == "polygon" || tag.name == "polyline") {
      const auto text = tag.attributes.find("points");
      std::vector<Vec2> points;
      if (text != tag.attributes.end()) {
        Scanner scan(text->second);
        while (!scan.done()) {
          const auto x = scan.number(), y = scan.number();
          if (!x || !y)
            bad(tag.line, "points: '" + printable(text->second) +
                              "' is not pairs of numbers; write it like 0,0 10,0 5,8");
          points.emplace_back(*x, *y);
        }
      }
      if (tag.name == "polyline" && points.size() > 1 && points.front() != points.back()) open(tag);
      add(tag, transform, std::move(points));
    } else if (tag.name == "rect") {
      const double x = number(tag, "x", 0), y = number(tag, "y", 0), w = number(tag, "width"),
                   h = number(tag, "height");
      if (!(w > 0) || !(h > 0)) bad(tag.line, "'rect' has no size; give a width and height above 0");
      double rx = number(tag, "rx", -1), ry = number(tag, "ry", -1);
      if (rx < 0) rx = std::max(ry, 0.0);
      if (ry < 0) ry = rx;
      rx = std::min(rx, w / 2), ry = std::min(ry, h / 2);
      std::vector<Vec2> points;
      const Vec2 centres[] = {
          {x + w - rx, y + ry}, {x + w - rx, y + h - ry}, {x + rx, y + h - ry}, {x + rx, y + ry}};
      for (int i = 0; i < 4; ++i) {
        const auto corner = [&](double t) {
          return Vec2(centres[i] + Vec2(rx * std::cos(t), ry * std::sin(t)));
        };
        points.push_back(corner((i - 1) * pi / 2));
        if (rx > 0 && ry > 0) append_curve(points, corner, (i - 1) * pi / 2, i * pi / 2, 1, tolerance);
      }
      add(tag, transform, std::move(points));
    } else if (tag.name == "circle") {
      const double r = number(tag, "r");
      oval(number(tag, "cx", 0), number(tag, "cy", 0), r, r);
    } else if (tag.name == "ellipse") {
      oval(number(tag, "cx", 0), number(tag, "cy", 0), number(tag, "rx"), number(tag, "ry"));
    } else if (tag.name == "line" || tag.name == "text" || tag.name == "image" || tag.name == "use" ||
               tag.name == "foreignObject") {
      ++left_out_[tag.name];
    }
  }

  [[noreturn]] void open(const Tag& tag) const {
    bad(tag.line, "a '" + tag.name + "' is open; close it: a slice needs closed rings");
  }

  void path(const Tag& tag, const std::string& d, const Affine& transform, double tolerance) {
    Scanner scan(d);
    std::vector<Vec2> points;
    Vec2 at = Vec2::Zero(), start = at, control = at;
    char command = '\0', before = '\0';
    bool closed = true;
    const auto finish = [&] {
      if (!closed && points.size() > 1 &&
          (points.back() - points.front()).norm() > 1e-9 * (1 + points.front().norm()))
        open(tag);
      add(tag, transform, std::move(points));
      points.clear();
      closed = true;
    };
    const auto value = [&] {
      const auto v = scan.number();
      if (!v)
        bad(tag.line, std::string("path: a number is missing after '") + command +
                          "'; write path data as SVG 1.1 has it");
      return *v;
    };
    const auto point = [&](bool relative) {
      const double x = value(), y = value();
      return Vec2(relative ? Vec2(at + Vec2(x, y)) : Vec2(x, y));
    };
    while (!scan.done()) {
      if (std::isalpha(static_cast<unsigned char>(scan.peek())) != 0) {
        command = scan.take();
      } else if (command == '\0' || command == 'Z' || command == 'z') {
        bad(tag.line, "path: '" + printable(d) +
                          "' has a number where a command is due; write path data as SVG 1.1 has it");
      } else if (command == 'M' || command == 'm') {
        command = command == 'M' ? 'L' : 'l';  // further pairs are lines
      }
      const bool relative = std::islower(static_cast<unsigned char>(command)) != 0;
      const char kind = static_cast<char>(std::toupper(static_cast<unsigned char>(command)));
      if (kind != 'M' && kind != 'Z' && points.empty()) {
        if (before == '\0') bad(tag.line, "path: does not begin with M; write path data as SVG 1.1 has it");
        points.push_back(at);
        closed = false;
      }
      const Vec2 from = at;
      const auto cubic = [&](const Vec2& a, const Vec2& b, const Vec2& to) {
        append_curve(
            points,
            [&](double t) {
              const double s = 1 - t;
              return Vec2(s * s * s * from + 3 * s * s * t * a + 3 * s * t * t * b + t * t * t * to);
            },
            0, 1, 2, tolerance);
        at = to, control = b;
      };
      const auto quadratic = [&](const Vec2& a, const Vec2& to) {
        append_curve(
            points,
            [&](double t) {
              const double s = 1 - t;
              return Vec2(s * s * from + 2 * s * t * a + t * t * to);
            },
            0, 1, 2, tolerance);
        at = to, control = a;
      };
      switch (kind) {
        case 'M':
          finish();
          at = start = point(relative);
          points.push_back(at);
          closed = false;
          break;
        case 'L':
          points.push_back(at = point(relative));
          break;
        case 'H':
          at.x() = (relative ? at.x() : 0) + value();
          points.push_back(at);
          break;
        case 'V':
          at.y() = (relative ? at.y() : 0) + value();
          points.push_back(at);
          break;
        case 'C': {
          const Vec2 a = point(relative), b = point(relative), to = point(relative);
          cubic(a, b, to);
          break;
        }
        case 'S': {
          const Vec2 a = before == 'C' || before == 'S' ? Vec2(2 * at - control) : at;
          const Vec2 b = point(relative), to = point(relative);
          cubic(a, b, to);
          break;
        }
        case 'Q': {
          const Vec2 a = point(relative), to = point(relative);
          quadratic(a, to);
          break;
        }
        case 'T':
          quadratic(before == 'Q' || before == 'T' ? Vec2(2 * at - control) : at, point(relative));
          break;
        case 'A': {
          const double rx = std::abs(value()), ry = std::abs(value()), turn = value() * pi / 180;
          const auto large = scan.flag(), sweep = scan.flag();
          if (!large || !sweep)
            bad(tag.line, "path: a flag of an arc is neither 0 nor 1; write path data as SVG 1.1 has it");
          const Vec2 to = point(relative);
          arc(points, from, to, rx, ry, turn, *large, *sweep, tolerance);
          at = to;
          break;
        }
        case 'Z':
          closed = true;
          finish();
          at = start;
          break;
        default:
          bad(tag.line, std::string("path: '") + printable(std::string(1, command)) +
                            "' is no command; write path data as SVG 1.1 has it");
      }
      before = kind;
    }
    finish();
  }

  // SVG 1.1, appendix F.6.5: from ends to the centre.
  static void arc(std::vector<Vec2>& points, const Vec2& from, const Vec2& to, double rx, double ry,
                  double turn, bool large, bool sweep, double tolerance) {
    if (from == to) return;
    if (rx == 0 || ry == 0) {
      points.push_back(to);
      return;
    }
    const Eigen::Rotation2Dd axes(turn);
    const Vec2 p = axes.inverse() * Vec2((from - to) / 2);
    const double grow = std::sqrt(p.x() * p.x() / (rx * rx) + p.y() * p.y() / (ry * ry));
    if (grow > 1) rx *= grow, ry *= grow;
    const double q = rx * rx * p.y() * p.y() + ry * ry * p.x() * p.x();
    double root = std::sqrt(std::max(0.0, (rx * rx * ry * ry - q) / q));
    if (large == sweep) root = -root;
    const Vec2 c(root * rx * p.y() / ry, -root * ry * p.x() / rx);
    const Vec2 u((p.x() - c.x()) / rx, (p.y() - c.y()) / ry), v((-p.x() - c.x()) / rx, (-p.y() - c.y()) / ry);
    const double t0 = std::atan2(u.y(), u.x());
    double span = std::atan2(cross(u, v), u.dot(v));
    if (sweep && span < 0) span += 2 * pi;
    if (!sweep && span > 0) span -= 2 * pi;
    const Vec2 centre = axes * c + (from + to) / 2;
    append_curve(
        points, [&](double t) { return Vec2(centre + axes * Vec2(rx * std::cos(t), ry * std::sin(t))); }, t0,
        t0 + span, 4, tolerance);
    points.back() = to;
  }

  const std::string& path_;
  const std::string text_;
  double tolerance_;
  std::size_t at_ = 0;
  int line_ = 1;
  std::vector<InputRing> rings_;
  std::vector<std::string> warnings_;
  std::map<std::string, int> left_out_;
};

}  // namespace

SliceFile read_slice_svg(const std::string& path, double tolerance_mm) {
  return Reader(path, tolerance_mm).read();
}

}  // namespace afptraj
