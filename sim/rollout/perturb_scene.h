// What a scene's section `perturbation` does to the rest of it [scene.h, Perturbation].
//
// The speed s of prescribed motions is left to BuildModel, which has the motions; here all times of the scene, which go
// with them, are divided by s: horizon and step, so that there are as many steps, samples, grips, schedules of targets,
// conditions and control intervals. In a scene without a prescribed motion there is nothing that a speed could be of,
// and it stays as it is.
#pragma once

#include "sim/scenarios/scene.h"

namespace knap {

// Without such a section: no effect.
void PerturbScene(Scene* scene);

// Roll, pitch, yaw of R = Rz(y) Ry(p) Rx(r), p within ±90°.
Eigen::Vector3d CalcRpy(const Eigen::Matrix3d& R);

}  // namespace knap
