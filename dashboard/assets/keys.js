// Keys: 1 to 9 and 0 open the pages, [ and ] the epoch before and after, up and down the slice above and below.
// Each is a link of the page, so that a key does what a click does.
(function () {
  "use strict";
  var BY_KEY = { "[": "key-before", "]": "key-after", ArrowUp: "key-up", ArrowDown: "key-down" };
  function typing(target) {
    return target.closest("input, textarea, select, [contenteditable], [role=listbox], [role=option], .dash-dropdown");
  }
  document.addEventListener("keydown", function (event) {
    if (event.ctrlKey || event.metaKey || event.altKey || typing(event.target)) return;
    var link = document.getElementById(BY_KEY[event.key] || "");
    if (!link && /^[0-9]$/.test(event.key)) {
      var links = document.querySelectorAll(".page-link");
      link = links[(Number(event.key) + 9) % 10];
    }
    if (!link) return;
    event.preventDefault();
    link.click();
  });
})();
