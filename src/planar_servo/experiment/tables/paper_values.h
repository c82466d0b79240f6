#pragma once

namespace planar {

// What the paper prints: circles in the order of its tables, lengths in millimetres.
constexpr double kPaperCorrelation[] = {0.991, 0.996, 0.993, 0.995};       // table 1
constexpr double kPaperIdw[] = {0.657, 0.796, 0.853};                      // table 2
constexpr double kPaperTrainingPlaces = 200, kPaperTestPlaces = 30;        // table 3
constexpr double kPaperRepeatability_mm = 0.004;                           // table 4: "less than"
constexpr double kPaperRbf[] = {0.905, 0.876, 0.953};                      // table 5
constexpr double kPaperAfter_mm[] = {0.185, 0.174, 0.180, 0.176};          // table 7
constexpr double kPaperImprovement[] = {0.877, 0.872, 0.857, 0.851};       // table 7
constexpr double kPaperBeforeMean_mm = 1.318, kPaperAfterMean_mm = 0.178;  // of the four circles
constexpr double kPaperImprovementMean = 0.864;                            // of the four circles

}  // namespace planar
