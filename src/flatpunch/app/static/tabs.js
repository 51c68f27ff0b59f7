// What each tab asks for besides the sample, and how it shows its result.

import { PRESS } from "./press.js";

export const TABS = { press: PRESS };
