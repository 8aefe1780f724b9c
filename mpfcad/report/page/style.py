"""The style sheet of the report: one column, readable on screen and on paper."""

STYLE = """
:root { --ink: #1d232a; --soft: #5a6570; --line: #d9dee3; }
* { box-sizing: border-box; }
body { margin: 0; background: #eef1f4; color: var(--ink);
  font: 15px/1.5 system-ui, -apple-system, "Segoe UI", "DejaVu Sans", sans-serif; }
main { max-width: 1080px; margin: 0 auto; background: #fff; padding: 36px 48px 60px; }
h1 { font-size: 26px; margin: 0 0 2px; }
h2 { font-size: 19px; margin: 40px 0 10px; padding-top: 14px; border-top: 2px solid var(--line); }
h3 { font-size: 15px; margin: 22px 0 6px; }
p { margin: 8px 0; } p.sub, .note { color: var(--soft); } .note { font-size: 13px; }
.banner { margin: 20px 0 16px; padding: 16px 20px; border-left: 8px solid; border-radius: 4px; }
.banner b { font-size: 22px; letter-spacing: .03em; display: block; }
.PASS.banner { background: #e7f4ea; border-color: #2c8a43; }
.MARGINAL.banner { background: #fdf5dd; border-color: #c79a12; }
.INCONCLUSIVE.banner { background: #eceff3; border-color: #6a7684; }
.FAIL.banner { background: #fbe6e4; border-color: #c0392b; }
td.PASS, td.MARGINAL, td.INCONCLUSIVE, td.FAIL { font-weight: 600; }
td.PASS { color: #1f7236; } td.MARGINAL { color: #96730a; }
td.INCONCLUSIVE { color: #55606c; } td.FAIL { color: #b02a1d; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; margin: 10px 0; font-size: 13.5px; }
th, td { text-align: left; padding: 5px 10px 5px 0; border-bottom: 1px solid var(--line);
  vertical-align: top; }
th { color: var(--soft); font-weight: 600; }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap;
  padding-right: 22px; }
code, .hash { font: 12.5px/1.45 ui-monospace, "DejaVu Sans Mono", monospace; }
.hash { overflow-wrap: anywhere; }
pre { background: #f4f6f8; padding: 10px 12px; border-radius: 4px; overflow-x: auto; }
.formula { font-style: italic; }
td.nowrap { white-space: nowrap; }
.tag { display: inline-block; padding: 0 7px; border-radius: 9px; font-size: 12px; }
.tag.given { background: #dcebf8; } .tag.sourced { background: #e1f1e4; }
.tag.assumed { background: #fbeccb; }
figure { margin: 14px 0; } figcaption { color: var(--soft); font-size: 13px; }
figure svg { width: 100%; height: auto; display: block; }
svg text { font-family: system-ui, "DejaVu Sans", sans-serif; }
.plot { width: 100%; }
footer { margin-top: 44px; color: var(--soft); font-size: 12.5px; }
@media (max-width: 700px) { main { padding: 20px 16px 40px; } }
@media print { body { background: #fff; font-size: 12px; } main { max-width: none; padding: 0; }
  h2 { break-after: avoid; } figure, tr, .banner { break-inside: avoid; }
  .banner, td.nowrap { white-space: nowrap; }
.tag { print-color-adjust: exact; -webkit-print-color-adjust: exact; } }
"""
