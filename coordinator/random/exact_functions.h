// Elementary functions of + - * / and sqrt alone, which IEEE 754 rounds exactly: the same bits on every processor,
// where libm picks variants. Errors are a few units in the last place.
#pragma once

namespace knap {

double CalcLogarithm(double x);                                   // x > 0, finite
double CalcExponential(double x);                                 // |x| < 700
double CalcArcTangent(double y, double x);                        // of y/x, in the quadrant of (x, y); 0 for (0, 0)
void CalcSineCosine(double angle, double* sine, double* cosine);  // |angle| < 1e6

}  // namespace knap
