#include "cli/build_facts.h"

#include "cli/versions.h"

namespace afptraj::cli {

const char* version() { return AFPTRAJ_VERSION; }

std::vector<std::pair<std::string, std::string>> versions() {
  return {{"afptraj", AFPTRAJ_VERSION},       {"OpenCASCADE", AFPTRAJ_OCCT_VERSION},
          {"Eigen", AFPTRAJ_EIGEN_VERSION},   {"CGAL", AFPTRAJ_CGAL_VERSION},
          {"Ceres", AFPTRAJ_CERES_VERSION},   {"TBB", AFPTRAJ_TBB_VERSION},
          {"toml11", AFPTRAJ_TOML11_VERSION}, {"nlohmann_json", AFPTRAJ_JSON_VERSION},
          {"CLI11", AFPTRAJ_CLI11_VERSION}};
}

std::string compiler() {
  const std::string type = AFPTRAJ_BUILD_TYPE;
  return std::string(AFPTRAJ_COMPILER) + (type.empty() ? "" : ", " + type);
}

}  // namespace afptraj::cli
