// How far labels without a stroke can be trusted: right share of the area, area in doubt, and whether what
// claims to be right to p is right to p (a reliability diagram), by area.
#pragma once

#include <string>
#include <vector>

#include "dataset/labelling/labeller.h"
#include "tests/bench/robot_reliability.h"
#include "tests/bench/robot_run.h"

namespace ohb {
using namespace labelling;
using namespace surface;

/// Of one person. Shares of the area.
struct RobotTrust {
  std::string scan;
  double accuracy = 0;
  double unsure = 0, in_doubt = 0;  // below kDoubtful; the same or asked about
  size_t questions = 0;
  double answered = 0;   // accuracy once the truth has answered them
  double border_mm = 0;  // then; see border_error_mm. Of one closed surface; else 0
  std::vector<Claim> claims;
};

RobotTrust trust_of(const RobotHuman& human, const Labelling& labels, const Garments& garments);

/// Mean distance of the borders found from the true ones and of the true ones from those found, in mm; what
/// is farther than 5 cm counts as 5 cm (a region that one of the two lacks).
double border_error_mm(const FaceGraph& graph, const std::vector<uint8_t>& face_class,
                       const std::vector<uint8_t>& truth);

std::string trust_line(const RobotTrust& of);
/// Medians and worst over the people, and their reliability.
std::string trust_text(const std::vector<RobotTrust>& people);

/// Labels every scan without a stroke, then answers all questions as the truth has it; prints a line a scan,
/// and trust_text. By the installed model; or, if `fitted` names a file, each person by a model of the
/// others, and the model of all is written there; generated people then teach alone, and are measured on
/// other seeds. `leather_share`: see LabelModel.
void measure_trust(const std::vector<RobotHuman>& humans, const std::string& fitted, float leather_share);

}  // namespace ohb
