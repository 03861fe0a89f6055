#pragma once

#include "fill/fill_path.h"
#include "fill/slice.h"

namespace afptraj {

/// How rings become one path.
enum class Connection {
  nested,  ///< two links side by side where two rings lie next to each other: out and back
  spiral,  ///< connected Fermat spirals: slanting links, in along every other ring and out along those
           ///< between
};

/// Joins the rings of `fill` that lie next to each other, and the open paths beside them, to as few paths as
/// can be: one for each connected part of a slice. The paths run along the rings as they are but for gaps of
/// about a width, which the links through them cover. An open path is run there and back from the ring
/// nearest to it.
///
/// nested: closed paths. Each link is the shortest that is free of other paths and links.
/// spiral: rings that lie in each other one by one are run as a double spiral, whose links advance by two
/// widths from ring to ring, so that the path turns by 27 degrees there; where rings are too short or turn
/// too much for that, and where spirals meet, links are nested.
///
/// Laws, checked by tests/connect_test.cpp:
///   (C1) Paths do not cross, and each point of them lies on a ring or on a link of at most seven widths,
///   which
///        does not leave the slice.
///   (C2) length = length of the rings - gaps + links, and all of each ring but its gaps is run, once.
///   (C3) Each part of the slice in which centre lines can lie gives one path.
///
/// Cost: O(n log n), n points of the rings. Source of the spirals: H. Zhao et al., Connected Fermat Spirals
/// for Layered Fabrication, ACM TOG 35 (2016); the rest: own.
Fill connected(const Fill& fill, const Slice& slice, double width_mm, Connection connection);

}  // namespace afptraj
