#pragma once

#include <memory>
#include <string>
#include <vector>

#include "geometry/skin.h"
#include "io/job_toml.h"
#include "io/step/read_step.h"
#include "trajectory/ply_orientation.h"

namespace afptraj::cli {

/// Thrown when a stop was asked for (see signals.h) and has been followed.
struct Stopped {};

/// Throws Stopped when a stop was asked for.
void check_stop();

/// Reads the part of a job; a stop asked for meanwhile becomes Stopped.
StepModel read_part(const std::string& path, const Job& job);

/// Trim regions of all faces of a part.
std::vector<std::shared_ptr<const TrimRegion>> trim_regions(const Part& part);

/// Face indices (from 0) that the job asks for, and how they were chosen. Throws Error(usage) for
/// numbers and names that the part does not have.
struct ChosenFaces {
  std::vector<int> faces;
  std::string reason;
};
ChosenFaces choose_faces(const std::shared_ptr<const Part>& part, const FaceChoice& choice,
                         const std::vector<PlyOrientation>& plies);

}  // namespace afptraj::cli
