#include "planar_servo/offline/map/lamp_field_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "planar_servo/field/arm/arm_terms.h"
#include "planar_servo/files/map/lamp_field_file.h"
#include "planar_servo/offline/arm/calibrate_arm.h"

namespace planar {
namespace {

void list_readings(ReportList& list, const LampFieldFit& fit) {
  list.line("readings used",
            "{n_readings}, and {n_unattended} poses without a reading ({n_rejected} left out)",
            fit.n_readings, fit.n_unattended, fit.left_out.size());
  list.unprinted("n_used", fit.n_readings + fit.n_unattended - fit.left_out.size());
  if (!fit.left_out.empty())
    list.line("", fmt::format("  contradicting the others: {}", fmt::join(fit.left_out, ", ")));
  list.rows("rejected", fit.left_out, [](ReportList& row, const std::string& id) {
    row.unprinted("id", id);
    row.unprinted("reason", "contradicts the others");
  });
}

void list_judgement(ReportList& list, const HeldOut& judged) {
  list.unprinted("worth_using", judged.worth_using());
  if (judged.n == 0) {
    list.line("places left out", "none: no tracker reading judges this map");
    return;
  }
  list.line("vision error", "{raw_rms_mm:.4f} mm rms", judged.raw_rms);
  list.line("places left out",
            "{loo_rms_mm:.4f} mm rms against the tracker, {coverage_95:.1%} of them within their "
            "stated 95 %",
            judged.rms, judged.coverage_95);
  list.line("gain",
            judged.worth_using() ? "{gain:.1%}, worth using"
                                 : "{gain:.1%}, NOT significant: do not use this map",
            1.0 - judged.rms / judged.raw_rms);
}

/// Says how the ways to predict the error compare.
void list_comparison(ReportList& list, const LampFieldFit& fit) {
  if (!fit.compared.empty())
    list.line("", "at places left out            mm rms   within stated 95 %");
  const auto list_way = [&fit](ReportList& row, const ComparedField& way) {
    const bool is_taken = way.rms == fit.held_out.rms;
    row.line("",
             fmt::format("{{name:<30}}{{loo_rms_mm:.4f}}   {{coverage_95:.1%}}{}",
                         is_taken ? ", taken" : ""),
             way.name, way.rms, way.coverage_95);
    row.unprinted("taken", is_taken);
  };
  list.rows("compared", fit.compared, list_way, "");
  if (!fit.compared.empty()) list.line("", "");
}

/// Says what each source added and what fixed the field as a whole.
void list_sources(ReportList& list, const LampFieldFit& fit) {
  list.line("source", "how much                  end point known without it to");
  const auto list_source = [](ReportList& row, const SourceWorth& source) {
    row.line("", "{source:<20}{amount:<26}{end_point_without_mm:.4f} mm", source.name,
             source.amount, source.end_point_without);
  };
  list.rows("sources", fit.sources, list_source, "");
  list.line("(with all)", "                          {end_point_sigma_mm:.4f} mm",
            fit.certainty.end_point);
  list.line("as a whole", "fixed by                  standard deviation");
  ReportList fixed_by;
  const auto list_fixed = [&](const char* what, FieldSource source, const std::string& text,
                              const auto&... sigma) {
    fixed_by.unprinted(what, name_in(kFieldSources, source));
    list.line(what, fmt::format("{:<26}", name_in(kFieldSources, source)) + text, sigma...);
  };
  list_fixed("scale", fit.fixed_by.scale, "{scale_sigma_ppm:.1f} ppm", fit.certainty.scale);
  list_fixed("datum", fit.fixed_by.datum, "{datum_sigma_mm:.4f} mm", fit.certainty.shift);
  if (fit.fixed_by.turn == FieldSource::kNothing)
    list_fixed("turn", fit.fixed_by.turn, "counted from the cell file's zero of joint 1");
  else
    list_fixed("turn", fit.fixed_by.turn, "{turn_sigma_deg:.5f} deg", fit.certainty.turn);
  list.part("fixed_by", fixed_by);
}

}  // namespace

ReportList lamp_field_list(const LampFieldFit& fit) {
  ReportList list;
  list_readings(list, fit);
  list.line("method", "{method}, {harmonics} harmonics of each reducer", kLampFieldMethod,
            fit.estimate.size.harmonics);
  list_judgement(list, fit.held_out);
  list.line("noise of a lamp", "{lamp_noise_factor:.2f} times what the pairs state\n",
            fit.estimate.priors.lamp_factor);
  list.unprinted("noise_mm", fit.noise_sigma);
  list_comparison(list, fit);
  list_sources(list, fit);
  list.line("", "");
  const std::vector<std::string> sentences = arm_in_words(fit.estimate);
  for (const std::string& sentence : sentences) list.line("", sentence);
  list.unprinted("arm_in_words", sentences);
  list.unprinted("scatter_mm", fit.estimate.priors.arm_sigma);
  list.line("", "\nwhat the poses say of the arm");
  list.part("arm", arm_terms_list(fit.estimate));
  return list;
}

}  // namespace planar
