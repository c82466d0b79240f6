// What became of a target, in the words of planar-servo's answers.

const WORDS = {
  reached: "reached", not_converged: "not converged", diverged: "diverged", held: "held", outside_map: "outside map",
  lost_lamp: "lamp lost", lost_camera: "camera lost", refused: "refused", doubted: "doubted"};

/// "planned", "reached", "outside" or "failed": how it is drawn.
export function kindOf(result) {
  if (!result) return "planned";
  if (result.status === "reached") return "reached";
  return result.status === "outside_map" ? "outside" : "failed";
}

export function stateText(result) {
  if (!result) return "";
  if (result.error) return result.error;
  return (WORDS[result.status] || result.status) + (result.reason ? `: ${result.reason}` : "");
}
