#include "io/fill_files.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "io/number_text.h"

namespace afptraj {
namespace {

using Json = nlohmann::ordered_json;

Json number(double x) { return std::isfinite(x) ? Json(rounded_number(x)) : Json(); }
Json percent(double share) { return rounded_number(100 * share, 6); }

Json options_json(const FillRecord& record) {
  Json out = Json::object();
  for (const auto& [name, text] : record.options) {
    const auto value = parse_number(text);
    out[name] = value ? Json(*value) : Json(text);
  }
  return out;
}

Json slice_json(const Slice& slice) {
  Json depths = Json::array();
  for (const SliceRing& ring : slice.rings()) {
    depths.push_back({{"points", ring.points.size()},
                      {"depth", ring.depth},
                      {"area_mm2", number(std::abs(signed_area(ring.points)))}});
  }
  return {{"area_mm2", number(slice.area_mm2())}, {"rings", depths}};
}

Json paths_json(const Fill& fill) {
  Json out = Json::array();
  for (const FillPath& path : fill.paths) {
    Json entry = {{"kind", to_string(path.kind)},
                  {"closed", path.line.closed},
                  {"points", path.line.points.size()},
                  {"length_mm", number(length_mm(path.line))}};
    if (path.kind == PathKind::ring) entry["level"] = path.level;
    out.push_back(entry);
  }
  return out;
}

Json leftovers_json(const Fill& fill) {
  Json out = Json::array();
  for (const Leftover& place : fill.leftovers) {
    out.push_back({{"where", {number(place.where.x()), number(place.where.y())}},
                   {"area_mm2", number(place.area_mm2)}});
  }
  return out;
}

class Picture {
 public:
  explicit Picture(const Slice& slice, double margin) {
    const std::vector<Vec2> points = points_of(slice);
    Vec2 lo = points.front(), hi = lo;
    for (const Vec2& p : points) lo = lo.cwiseMin(p), hi = hi.cwiseMax(p);
    lo -= Vec2::Constant(margin), hi += Vec2::Constant(margin);
    top_ = hi.y() + lo.y();  // y is turned over within the box
    text_ = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"" + three(lo.x()) + " " + three(lo.y()) +
            " " + three(hi.x() - lo.x()) + " " + three(hi.y() - lo.y()) + "\" width=\"800\">\n" +
            "<rect x=\"" + three(lo.x()) + "\" y=\"" + three(lo.y()) + "\" width=\"" +
            three(hi.x() - lo.x()) + "\" height=\"" + three(hi.y() - lo.y()) + "\" fill=\"white\"/>\n";
  }
  static std::string three(double x) { return number_text(x, 3); }
  void open(const std::string& attributes) { text_ += "<g " + attributes + ">\n"; }
  void close() { text_ += "</g>\n"; }
  std::string chain(const std::vector<Vec2>& points, bool closed) const {
    std::string d = "M";
    for (const Vec2& p : points) d += " " + three(p.x()) + " " + three(top_ - p.y());
    return closed ? d + " Z" : d;
  }
  void path(const std::string& d) { text_ += "<path d=\"" + d + "\"/>\n"; }
  std::string text() const { return text_ + "</svg>\n"; }

 private:
  double top_ = 0;
  std::string text_;
};

const char* colour(PathKind kind) {
  switch (kind) {
    case PathKind::centre:
      return "#b3261e";
    case PathKind::outline:
      return "#1b5e20";
    default:
      return "#0b3d91";
  }
}

}  // namespace

std::string to_string(PathKind kind) {
  switch (kind) {
    case PathKind::ring:
      return "ring";
    case PathKind::outline:
      return "outline";
    case PathKind::line:
      return "line";
    case PathKind::centre:
      return "centre";
    case PathKind::joined:
      return "joined";
  }
  return {};
}

std::string fill_paths_csv(const Fill& fill, double z_mm) {
  std::string text = "path,closed,i,x,y,z\n";
  const std::string z = number_text(z_mm);
  for (std::size_t k = 0; k < fill.paths.size(); ++k) {
    const Polyline& line = fill.paths[k].line;
    const std::string start = std::to_string(k) + (line.closed ? ",1," : ",0,");
    for (std::size_t i = 0; i < line.points.size(); ++i) {
      text += start + std::to_string(i) + ',';
      append_number(text, line.points[i].x());
      text += ',';
      append_number(text, line.points[i].y());
      text += ',' + z + '\n';
    }
  }
  return text;
}

std::string fill_summary_json(const FillRecord& record, const Slice& slice, const Fill& fill,
                              const FillReport& report) {
  Json out;
  for (const auto& [name, version] : record.versions) out["versions"][name] = version;
  for (const InputRecord& input : record.inputs)
    out["inputs"][input.role] = {{"path", input.path}, {"sha256", input.sha256}};
  out["options"] = options_json(record);
  out["slice"] = slice_json(slice);
  out["fill"] = {{"paths", report.paths},
                 {"length_mm", number(report.length_mm)},
                 {"travel_mm", number(report.travel_mm)},
                 {"links", fill.links.count},
                 {"link_length_mm", number(fill.links.length_mm)},
                 {"longest_link_mm", number(fill.links.longest_mm)},
                 {"covered_mm2", number(report.covered_mm2)},
                 {"underfill_percent", percent(report.underfill)},
                 {"unreachable_percent", percent(report.unreachable)},
                 {"overfill_percent", percent(report.overfill)},
                 {"overfill_with_ends_percent", percent(report.overfill_with_ends)},
                 {"outside_percent", percent(report.outside)},
                 {"sharp_corners", report.sharp_corners},
                 {"min_turning_radius_mm", number(report.min_turning_radius_mm)}};
  out["paths"] = paths_json(fill);
  out["leftovers"] = leftovers_json(fill);
  out["warnings"] = record.warnings;
  out["files"] = record.files;
  Json stages = Json::object();
  for (const StageTime& time : record.times) stages[time.stage] = rounded_number(time.seconds, 6);
  out["times"] = {{"started", record.started}, {"stages_s", stages}};
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string fill_svg(const Slice& slice, const Fill& fill, double width_mm) {
  Picture picture(slice, width_mm);
  std::string outline;
  for (const SliceRing& ring : slice.rings()) outline += picture.chain(ring.points, true) + " ";
  picture.open("fill=\"#d9d9d9\" fill-rule=\"evenodd\" stroke=\"none\"");
  picture.path(outline);
  picture.close();
  // each bead on its own, so that what is laid twice is darker
  picture.open(
      "fill=\"none\" stroke=\"#4f8fd9\" stroke-opacity=\"0.5\" stroke-linecap=\"round\" "
      "stroke-linejoin=\"round\" stroke-width=\"" +
      Picture::three(width_mm) + "\"");
  for (const FillPath& path : fill.paths) picture.path(picture.chain(path.line.points, path.line.closed));
  picture.close();
  for (const PathKind kind :
       {PathKind::ring, PathKind::outline, PathKind::line, PathKind::joined, PathKind::centre}) {
    if (std::none_of(fill.paths.begin(), fill.paths.end(), [&](const FillPath& p) { return p.kind == kind; }))
      continue;
    picture.open("fill=\"none\" stroke=\"" + std::string(colour(kind)) + "\" stroke-width=\"" +
                 Picture::three(width_mm / 12) + "\"");
    for (const FillPath& path : fill.paths) {
      if (path.kind == kind) picture.path(picture.chain(path.line.points, path.line.closed));
    }
    picture.close();
  }
  picture.open("fill=\"none\" stroke=\"black\" stroke-width=\"" + Picture::three(width_mm / 20) + "\"");
  picture.path(outline);
  picture.close();
  return picture.text();
}

}  // namespace afptraj
