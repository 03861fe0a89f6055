#include "io/step/read_step.h"

#include "geometry/error.h"
#include "io/step/collect.h"
#include "io/step/import.h"
#include "io/step/isolate.h"
#include "io/step/join_edges.h"
#include "io/step/part_codec.h"
#include "io/step/sha256.h"
#include "io/step/step_text.h"

namespace afptraj {

StepModel read_step(const std::filesystem::path& path, const StepReadOptions& options) {
  using namespace step;
  const std::string where = path.string();
  if (!options.unit_override.empty() && !millimetres_in(options.unit_override)) {
    throw Error(ErrorCode::usage, "--unit",
                "\"" + options.unit_override + "\" is not a unit of length; use mm, cm, m, in or ft");
  }
  const std::string bytes = read_file(path, options.max_file_bytes);
  const StepText text = check_step_text(bytes, where);
  PlainModel plain;
  if (options.isolate) {
    const IsolationLimits limits{options.timeout_s, options.memory_limit_bytes, options.stop};
    plain = decode(run_isolated(
        where, limits, [&] { return encode(import_part(bytes, text, where, options)); },
        [&] { return find_cycle(text).value_or(""); }));
  } else {
    plain = import_part(bytes, text, where, options);
  }
  std::vector<int> bodies;
  for (const PlainFace& face : plain.faces) bodies.push_back(face.body);
  StepModel model = to_step_model(std::move(plain), where);
  model.sha256 = sha256_hex(bytes);
  for (std::string& warning : find_broken_references(text)) model.warnings.push_back(std::move(warning));
  join_edges(model, bodies, options.sew_tolerance_mm);
  return model;
}

}  // namespace afptraj
