#pragma once

#include <Eigen/Core>

#include "sim/geometry/triangle_mesh.h"

namespace knap {

// Mean value coordinates of a point x in a closed triangle mesh, the cage: weights lambda_j(x), one for each
// cage vertex c_j, that extend functions from the cage's surface into space. A function f that is linear on
// every cage triangle gets the value [Ju, Schaefer, Warren 2005, Eq. 2]
//
//   sum_j lambda_j(x) f(c_j) = int_S f(p) / |p - x| dS / int_S 1 / |p - x| dS,
//
// where S is the unit sphere of directions about x and p the cage point in that direction (all of them
// where a direction meets the cage more than once, with the sign of the crossing). The weights sum to one
// and reproduce linear functions, so moving the cage by an affine map moves x by the same map. They are
// smooth inside and outside, continuous on the cage, where they are barycentric, and never negative inside
// a convex cage.
//
// Evaluation: for a triangle with corners at distances d_i, unit directions u_i and edge normals n_i (of the
// plane through x and the edge opposite to corner i), the integral of the directions over the triangle's
// shadow on S is the mean vector m = 1/2 sum_i theta_i n_i, with the angle of the edge
// theta_i = 2 atan2(|u - v|, |u + v|), and the triangle adds [same, Eqs. 10 to 12]
//
//   w_i = (n_i . m) / (d_i n_i . u_i)
//
// to its corners; lambda = w / sum w. This form keeps all digits near the faces, where the cosine form of
// the paper's Fig. 4 loses half of them. Two cases need their limits: within 1e-12 of the cage's diagonal
// from a triangle the weights are the barycentric ones of the nearest point; and a triangle seen edge-on
// (height of x over its plane below 1e-8 of its distance) casts no shadow and adds nothing.

// Throws std::invalid_argument with one line if `cage` is not closed, manifold and oriented outwards, or has
// unused vertices (FindDefects).
void CheckCage(const TriangleMesh& cage);

// Returns lambda (n_cage) at the point p [m], in the cage's frame. O(number of triangles). The cage must
// have passed CheckCage. p may lie inside, outside or on it; it must be finite.
Eigen::VectorXd CalcMeanValueCoordinates(const TriangleMesh& cage, const Eigen::Vector3d& p);

// Returns the matrix W (n_mesh x n_cage) whose row i is lambda at vertex i of `mesh`, so that
// mesh = W * cage for vertices as rows. Checks the cage.
Eigen::MatrixXd CalcMeanValueWeights(const TriangleMesh& cage, const TriangleMesh& mesh);

}  // namespace knap
