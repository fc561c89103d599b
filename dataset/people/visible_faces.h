// Faces that can be seen from outside, and hair as what of its cards is not empty.
#pragma once

#include "dataset/people/person.h"

namespace ohb::people {

/// All that can be seen or hide something: the kept faces of all parts but brows, in the pose.
SurfaceQuery surface_of(const Person& person);

/// Keeps the faces that a ray reaches from outside, and their neighbours. Gives the number dropped.
size_t drop_unseen_faces(Person& person);

/// Opacity (0 to 1) of a part's picture at a UV.
using Opacity = std::function<float(Vec2f uv)>;

/// Splits each face in four (quads and triangles), so that a card's outline can follow its picture.
void split_faces(Part& part);

/// Drops the faces that are emptier than 45 %.
void drop_empty_faces(Part& part, const Opacity& opacity);

}  // namespace ohb::people
