// What each tab asks for besides the sample, and how it shows its result.

import { COATING } from "./coating.js";
import { COMPARE } from "./compare.js";
import { CORRECT } from "./correct.js";
import { FIT } from "./fit.js";
import { PRESS } from "./press.js";
import { SLIP } from "./slip.js";

export const TABS = { press: PRESS, fit: FIT, correct: CORRECT, coating: COATING, slip: SLIP, compare: COMPARE };
