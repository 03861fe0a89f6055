#include "io/step/units.h"

#include <STEPConstruct_UnitContext.hxx>
#include <StepBasic_ConversionBasedUnit.hxx>
#include <StepBasic_ConversionBasedUnitAndLengthUnit.hxx>
#include <StepBasic_DimensionalExponents.hxx>
#include <StepBasic_HArray1OfNamedUnit.hxx>
#include <StepBasic_LengthMeasureWithUnit.hxx>
#include <StepBasic_LengthUnit.hxx>
#include <StepBasic_MeasureValueMember.hxx>
#include <StepBasic_NamedUnit.hxx>
#include <StepBasic_SiUnitAndLengthUnit.hxx>
#include <StepBasic_Unit.hxx>
#include <StepGeom_GeomRepContextAndGlobUnitAssCtxAndGlobUncertaintyAssCtx.hxx>
#include <StepGeom_GeometricRepresentationContextAndGlobalUnitAssignedContext.hxx>
#include <StepRepr_GlobalUnitAssignedContext.hxx>
#include <TCollection_HAsciiString.hxx>
#include <algorithm>
#include <cmath>

namespace afptraj::step {
namespace {

bool is_length(const Handle(StepBasic_NamedUnit)& unit) {
  if (unit.IsNull()) return false;
  if (unit->IsKind(STANDARD_TYPE(StepBasic_SiUnitAndLengthUnit)) ||
      unit->IsKind(STANDARD_TYPE(StepBasic_ConversionBasedUnitAndLengthUnit)) ||
      unit->IsKind(STANDARD_TYPE(StepBasic_LengthUnit))) {
    return true;
  }
  const auto si = Handle(StepBasic_SiUnit)::DownCast(unit);
  return !si.IsNull() && si->Name() == StepBasic_sunMetre;
}

std::string si_name(const Handle(StepBasic_SiUnit)& unit) {
  std::string prefix;
  if (unit->HasPrefix()) {
    switch (unit->Prefix()) {
      case StepBasic_spExa:
        prefix = "exa";
        break;
      case StepBasic_spPeta:
        prefix = "peta";
        break;
      case StepBasic_spTera:
        prefix = "tera";
        break;
      case StepBasic_spGiga:
        prefix = "giga";
        break;
      case StepBasic_spMega:
        prefix = "mega";
        break;
      case StepBasic_spKilo:
        prefix = "kilo";
        break;
      case StepBasic_spHecto:
        prefix = "hecto";
        break;
      case StepBasic_spDeca:
        prefix = "deca";
        break;
      case StepBasic_spDeci:
        prefix = "deci";
        break;
      case StepBasic_spCenti:
        prefix = "centi";
        break;
      case StepBasic_spMilli:
        prefix = "milli";
        break;
      case StepBasic_spMicro:
        prefix = "micro";
        break;
      case StepBasic_spNano:
        prefix = "nano";
        break;
      case StepBasic_spPico:
        prefix = "pico";
        break;
      case StepBasic_spFemto:
        prefix = "femto";
        break;
      case StepBasic_spAtto:
        prefix = "atto";
        break;
    }
  }
  return prefix + "metre";
}

std::string name_of(const Handle(StepBasic_NamedUnit)& unit) {
  if (const auto si = Handle(StepBasic_SiUnit)::DownCast(unit)) return si_name(si);
  if (const auto based = Handle(StepBasic_ConversionBasedUnit)::DownCast(unit)) {
    if (!based->Name().IsNull()) return based->Name()->ToCString();
  }
  return "length unit";
}

template <class Visit>
void for_each_context(const Handle(StepData_StepModel)& model, Visit visit) {
  for (int i = 1; i <= model->NbEntities(); ++i) {
    const Handle(Standard_Transient) entity = model->Value(i);
    Handle(StepRepr_GlobalUnitAssignedContext) context;
    if (const auto both =
            Handle(StepGeom_GeometricRepresentationContextAndGlobalUnitAssignedContext)::DownCast(entity)) {
      context = both->GlobalUnitAssignedContext();
    } else if (const auto all =
                   Handle(StepGeom_GeomRepContextAndGlobUnitAssCtxAndGlobUncertaintyAssCtx)::DownCast(
                       entity)) {
      context = all->GlobalUnitAssignedContext();
    } else {
      context = Handle(StepRepr_GlobalUnitAssignedContext)::DownCast(entity);
    }
    if (!context.IsNull() && !context->Units().IsNull()) visit(context->Units());
  }
}

}  // namespace

LengthUnits length_units(const Handle(StepData_StepModel)& model) {
  LengthUnits result;
  for_each_context(model, [&](const Handle(StepBasic_HArray1OfNamedUnit)& units) {
    bool has_one = false;
    for (int k = units->Lower(); k <= units->Upper(); ++k) {
      const Handle(StepBasic_NamedUnit) unit = units->Value(k);
      if (!is_length(unit)) continue;
      has_one = true;
      STEPConstruct_UnitContext factors;
      factors.ComputeFactors(unit);
      if (!factors.LengthDone()) continue;
      const bool seen = std::any_of(result.millimetres.begin(), result.millimetres.end(), [&](double known) {
        return std::abs(known - factors.LengthFactor()) <= 1e-9 * known;
      });
      if (seen) continue;
      result.names.push_back(name_of(unit));
      result.millimetres.push_back(factors.LengthFactor());
    }
    result.all_contexts_have_one = result.all_contexts_have_one && has_one;
  });
  return result;
}

void replace_length_units(const Handle(StepData_StepModel)& model, double millimetres) {
  const Handle(StepBasic_SiUnitAndLengthUnit) base = new StepBasic_SiUnitAndLengthUnit;
  base->Init(Standard_True, StepBasic_spMilli, StepBasic_sunMetre);
  const Handle(StepBasic_MeasureValueMember) value = new StepBasic_MeasureValueMember;
  value->SetName("LENGTH_MEASURE");
  value->SetReal(millimetres);
  StepBasic_Unit base_unit;
  base_unit.SetValue(base);
  const Handle(StepBasic_LengthMeasureWithUnit) measure = new StepBasic_LengthMeasureWithUnit;
  measure->Init(value, base_unit);
  const Handle(StepBasic_DimensionalExponents) exponents = new StepBasic_DimensionalExponents;
  exponents->Init(1, 0, 0, 0, 0, 0, 0);
  const Handle(StepBasic_ConversionBasedUnitAndLengthUnit) unit =
      new StepBasic_ConversionBasedUnitAndLengthUnit;
  unit->Init(exponents, new TCollection_HAsciiString("OVERRIDE"), measure);
  for_each_context(model, [&](const Handle(StepBasic_HArray1OfNamedUnit)& units) {
    for (int k = units->Lower(); k <= units->Upper(); ++k) {
      if (is_length(units->Value(k))) units->SetValue(k, unit);
    }
  });
}

}  // namespace afptraj::step
