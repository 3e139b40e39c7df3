#pragma once

namespace dualpixel::evaluation {

/// Style of pages about failures: tables of breaking points from red (at once) to green (never), strips of pictures.
inline constexpr const char* kFailureStyle = R"css(
.atlas td { padding: .35rem .8rem; text-align: left; line-height: 1.25; white-space: normal; }
.atlas thead td { font-weight: 600; }
.atlas a { color: inherit; text-decoration: none; display: block; }
.atlas a:hover { text-decoration: underline; }
.s0, .s1, .s2, .s3, .s4, .s5 { color: #1c1d20; }
.s0 .soft, .s1 .soft, .s2 .soft, .s3 .soft, .s4 .soft, .s5 .soft { color: #3c3d44; }
.s0 { background: #f0988f; } .s1 { background: #f6b98d; } .s2 { background: #f8d694; }
.s3 { background: #eee8a4; } .s4 { background: #cfe3a4; } .s5 { background: #a6d6a4; }
.strips td, .strips th { padding: .15rem; text-align: center; }
.strips th:first-child { text-align: left; padding-right: .8rem; white-space: normal; min-width: 8rem; }
.strips img { width: 104px; border: 2px solid transparent; }
.strips .broken img { border-color: #d0342c; }
:target { background: #f6e08a; color: #1c1d20; }
)css";

}  // namespace dualpixel::evaluation
