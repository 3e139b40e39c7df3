-- Links from page to page: what was page.md is page.html, and a folder's README is its index.
local function to_page(target)
  if target:match("^%a+:") then return target end
  return (target:gsub("README%.md", "index.html"):gsub("%.md$", ".html"):gsub("%.md#", ".html#"))
end

function Link(link)
  link.target = to_page(link.target)
  return link
end
