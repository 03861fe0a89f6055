#include "io/tows_csv.h"

#include <tbb/parallel_for.h>

#include "io/number_text.h"
#include "io/paths_csv.h"

namespace afptraj {
namespace {

constexpr std::size_t samples_at_once = 65536;  // some 150 bytes each

void append_vector(std::string& text, const Vec3& v) {
  for (Eigen::Index i = 0; i < 3; ++i) {
    text += ',';
    append_number(text, v[i]);
  }
}

void append_piece(std::string& text, const std::string& name, const TowPiece& piece) {
  const std::string start = name + ',' + std::to_string(piece.course) + ',' + std::to_string(piece.tow) + ',' +
                            std::to_string(piece.segment) + ',';
  for (std::size_t i = 0; i < piece.samples.size(); ++i) {
    const TowSample& sample = piece.samples[i];
    text += start;
    text += std::to_string(i + 1);
    text += i == 0 ? ",add," : i + 1 == piece.samples.size() ? ",cut," : ",,";
    append_number(text, sample.s_mm);
    append_vector(text, sample.position);
    append_vector(text, sample.normal);
    append_vector(text, sample.tangent);
    text += '\n';
  }
}

}  // namespace

void tows_csv(const std::vector<Ply>& plies, const TextSink& sink) {
  sink("ply,course,tow,segment,point,event,s_mm,x,y,z,nx,ny,nz,tx,ty,tz\n");
  for (const Ply& ply : plies) {
    const std::string name = csv_field(ply.name);
    std::vector<std::string> texts;
    for (std::size_t first = 0; first < ply.tows.size();) {
      std::size_t last = first, samples = 0;
      while (last < ply.tows.size() && samples < samples_at_once) samples += ply.tows[last++].samples.size();
      texts.resize(last - first);
      tbb::parallel_for(first, last, [&](std::size_t i) {
        std::string& text = texts[i - first];
        text.clear();
        text.reserve(160 * ply.tows[i].samples.size());
        append_piece(text, name, ply.tows[i]);
      });
      for (const std::string& text : texts) sink(text);
      first = last;
    }
  }
}

std::string tows_csv(const std::vector<Ply>& plies) {
  std::string text;
  tows_csv(plies, [&](std::string_view part) { text += part; });
  return text;
}

}  // namespace afptraj
