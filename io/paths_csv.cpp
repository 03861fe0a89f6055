#include "io/paths_csv.h"

#include "io/number_text.h"

namespace afptraj {
namespace {

void append_vector(std::string& text, const Vec3& v) {
  for (Eigen::Index i = 0; i < 3; ++i) {
    text += ',';
    append_number(text, v[i]);
  }
}

void append_sample(std::string& text, const CourseSample& sample) {
  text += ',';
  append_number(text, sample.s_mm);
  append_vector(text, sample.position);
  append_vector(text, sample.normal);
  append_vector(text, sample.tangent);
  for (const double curvature : {sample.kn_per_mm, sample.kg_per_mm}) {
    text += ',';
    append_number(text, curvature, 12);
  }
  text += ',';
  append_number(text, sample.deviation_rad * 180 / pi);
  text += '\n';
}

}  // namespace

std::string csv_field(const std::string& text) {
  const bool special = text.find_first_of(",\"\r\n") != std::string::npos;
  const bool formula = !text.empty() && std::string("=+-@#\t ").find(text.front()) != std::string::npos;
  const bool blank_end = !text.empty() && (text.back() == ' ' || text.back() == '\t');
  if (!special && !formula && !blank_end) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

std::string paths_csv(const std::vector<Ply>& plies) {
  std::string text =
      "ply,course,segment,point,s_mm,x,y,z,nx,ny,nz,tx,ty,tz,kn_per_mm,kg_per_mm,deviation_deg\n";
  for (const Ply& ply : plies) {
    const std::string name = csv_field(ply.name);
    for (const Course& course : ply.courses) {
      for (std::size_t segment = 0; segment < course.segments.size(); ++segment) {
        const std::string start =
            name + ',' + std::to_string(course.number) + ',' + std::to_string(segment + 1) + ',';
        const auto& samples = course.segments[segment].samples;
        for (std::size_t point = 0; point < samples.size(); ++point) {
          text += start;
          text += std::to_string(point + 1);
          append_sample(text, samples[point]);
        }
      }
    }
  }
  return text;
}

}  // namespace afptraj
