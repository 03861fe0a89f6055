#pragma once

// Private to io/step: the length unit of a STEP model.

#include <StepData_StepModel.hxx>
#include <string>
#include <vector>

namespace afptraj::step {

struct LengthUnits {
  std::vector<std::string> names;   ///< distinct, in the order of the file; empty: none declared
  std::vector<double> millimetres;  ///< of each
  bool all_contexts_have_one = true;
};
LengthUnits length_units(const Handle(StepData_StepModel)& model);

/// Puts a unit of `millimetres` in the place of every length unit of the model's contexts.
void replace_length_units(const Handle(StepData_StepModel)& model, double millimetres);

}  // namespace afptraj::step
