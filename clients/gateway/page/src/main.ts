// SPDX-License-Identifier: Apache-2.0
import "uplot/dist/uPlot.min.css";
import "./style.css";

import { Model } from "./model";
import { Shell } from "./ui/shell";

/** The token remains in the address of the page and is stored nowhere else. */
function gatewayUrl(): string {
  const url = new URL(location.href);
  const token = url.searchParams.get("token");
  const gateway = new URL(`${url.protocol === "https:" ? "wss:" : "ws:"}//${url.host}/`);
  if (token !== null) gateway.searchParams.set("token", token);
  return gateway.href;
}

const app = document.getElementById("app");
if (app !== null) new Shell(new Model(gatewayUrl()), app);
