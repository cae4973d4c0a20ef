# Set up tiltwatch on Windows: .venv, the locked packages, the command.
#
#   powershell -ExecutionPolicy Bypass -File infra\install.ps1
#   .venv\Scripts\tiltwatch demo
#
# NOT TRIED: written where no Windows was at hand. That the lock resolves to ready-made packages for Windows
# with Python 3.11 to 3.14 was tried (infra/README.md). May be called again: an interrupted set-up is begun anew.
param([string]$Python = "")
$ErrorActionPreference = "Stop"
Set-Location -LiteralPath (Split-Path -Parent $PSScriptRoot)

function Say([string]$Text) { [Console]::Error.WriteLine("set-up: $Text") }

# Asked by running it: the shop's placeholder is called python.exe too, and does not run.
function Test-Python([string[]]$Command) {
    $name, $rest = $Command
    if (-not (Get-Command $name -ErrorAction SilentlyContinue)) { return $false }
    $ask = "import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 11) or sys.maxsize < 2**32)"
    try { & $name @rest -c $ask 2>$null | Out-Null } catch { return $false }
    return $LASTEXITCODE -eq 0
}

function Invoke-Checked([string]$What, [string]$Program, [string[]]$Arguments) {
    & $Program @Arguments
    if ($LASTEXITCODE -ne 0) { Say "$What failed"; exit 1 }
}

# inherited settings that would leave sources uncompiled or put packages elsewhere
foreach ($name in "PYTHONDONTWRITEBYTECODE", "PYTHONPATH", "PYTHONHOME") {
    Remove-Item "Env:$name" -ErrorAction SilentlyContinue
}
$env:PIP_USER = "0"
$env:PIP_DISABLE_PIP_VERSION_CHECK = "1"

$here = (Get-Location).ProviderPath
$ready = Join-Path $here ".venv\ready"
$venvPython = Join-Path $here ".venv\Scripts\python.exe"

# no mark, or the mark of another folder: interrupted, or the checkout was moved
if ((Test-Path -LiteralPath ".venv") -and
    (-not (Test-Path -LiteralPath $ready) -or (Get-Content -LiteralPath $ready -Encoding UTF8) -ne $here)) {
    Say ".venv is not whole; making it anew"
    Remove-Item -LiteralPath ".venv" -Recurse -Force
}
if (-not (Test-Path -LiteralPath $venvPython)) {
    $candidates = @(@("py", "-3"), @("py", "-3.13"), @("py", "-3.12"), @("py", "-3.11"), @("python"), @("python3"))
    if ($Python) { $candidates = @(, @($Python)) }
    $found = $null
    foreach ($candidate in $candidates) {
        if (Test-Python $candidate) { $found = $candidate; break }
    }
    if ($null -eq $found) {
        Say "no Python 3.11 or newer (64 bit) found; install it, or name it: install.ps1 -Python C:\path\to\python.exe"
        exit 1
    }
    $name, $rest = $found
    Say "making .venv with $($found -join ' ')"
    Invoke-Checked "making .venv" $name (@($rest) + @("-m", "venv", ".venv") | Where-Object { $_ })
}
# taken away while work goes on, so that an interrupted set-up is seen
Remove-Item -LiteralPath $ready -ErrorAction SilentlyContinue

Say "installing the locked packages (about 1.5 GB, by hash)"
Invoke-Checked "installing the locked packages" $venvPython @(
    "-m", "pip", "install", "--quiet", "--require-hashes", "-r", "requirements.lock")
Invoke-Checked "installing tiltwatch" $venvPython @(
    "-m", "pip", "install", "--quiet", "--no-deps", "--no-build-isolation", "-e", ".")
Invoke-Checked "compiling" $venvPython @("-m", "compileall", "-q", "flows", "tasks", "storage")

& $venvPython -c "from tasks.simulation.raycasting import import_open3d; import_open3d()"
if ($LASTEXITCODE -ne 0) {
    Say "open3d does not load; without it there is no simulation, so no demo. It needs Microsoft's Visual C++ runtime."
}
Say "compiling the numeric loops, once (half a minute)"
& $venvPython -m flows.compile_kernels
Set-Content -LiteralPath $ready -Value $here -Encoding UTF8
Say "ready: .venv\Scripts\tiltwatch --help"
