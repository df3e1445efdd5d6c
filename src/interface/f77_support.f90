!> What the Fortran 77 entry points have in common, and the work of those whose arguments are not those of
!> one call of the C interface. The entry points themselves (f77.f90) are generated: tools/f77_entries.txt.
module gracecg_interface_f77_support
    use, intrinsic :: iso_c_binding, only: c_char, c_int, c_intptr_t, c_null_char, c_size_t
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t, c_utc_t, MESSAGE_SIZE, STATUS_OK, STATUS_BAD_SIZE, &
        STATUS_NOT_CONVERGED, free_object, start, raise
    use gracecg_interface_c_estimation, only: c_solution_t, c_beliefs_t, c_test_beliefs, &
        c_estimate, c_observations_counts, create_observations, &
        setup_with_moments
    use gracecg_interface_c_fit, only: c_fit_open, c_fit_free, c_fit_counts, c_fit_series, c_fit_running
    use gracecg_interface_c_general, only: c_earth_orientation
    use gracecg_interface_c_planning, only: c_bound_t, c_case_bound, c_design_settings_t, c_design_defaults, &
        c_design_t, c_design_manoeuvre, c_design_along, c_rod_t, c_case_rods, c_map
    implicit none
    private
    public :: c_text, c_handle, finish, finish_handle
    public :: free_any, observation_counts, observation_arrays, measured_setup, estimate_arrays, belief_arrays
    public :: bound_arrays, design_defaults_arrays, design_arrays, design_along_arrays, rod_arrays, map_arrays
    public :: residual_arrays, running_arrays, orientation_array

contains

    !> A name as C wants it: without blanks at the end, closed by a zero.
    pure function c_text(name) result(text)
        character(*), intent(in) :: name    !! Blanks at the end do not count
        character(len_trim(name) + 1) :: text

        text = trim(name)//c_null_char
    end function c_text

    !> A handle as C knows it.
    pure integer(c_intptr_t) function c_handle(handle)
        integer, intent(in) :: handle   !! 0 when there is none

        c_handle = handle
    end function c_handle

    !> Status and message of a call; the message is filled up with blanks, or cut off.
    subroutine finish(status, error, istat, msg)
        integer(c_int), intent(in) :: status    !! A gracecg_status
        type(c_error_t), intent(in) :: error
        integer, intent(out) :: istat
        character(*), intent(inout) :: msg

        integer :: i

        istat = status
        msg = ' '
        do i = 1, min(len(msg), MESSAGE_SIZE)
            if (error%message(i) == c_null_char) exit
            msg(i:i) = error%message(i)
        end do
    end subroutine finish

    !> The same of a call that made an object.
    subroutine finish_handle(status, error, handle, ih, istat, msg)
        integer(c_int), intent(in) :: status        !! A gracecg_status
        type(c_error_t), intent(in) :: error
        integer(c_intptr_t), intent(in) :: handle   !! As C knows it
        integer, intent(out) :: ih                  !! As Fortran 77 knows it
        integer, intent(out) :: istat
        character(*), intent(inout) :: msg

        ih = int(handle)
        call finish(status, error, istat, msg)
    end subroutine finish_handle

    !> Frees an object of any kind.
    function free_any(ih, error) result(status)
        integer, intent(inout) :: ih            !! 0 out
        type(c_error_t), intent(inout) :: error
        integer(c_int) :: status                !! A gracecg_status

        integer(c_intptr_t) :: handle

        handle = ih
        call free_object(handle, 'gracecg object', status, error)
        ih = int(handle)
    end function free_any

    !> Numbers of samples of an observation set.
    function observation_counts(iobs, n, error) result(status)
        integer(c_intptr_t), intent(in) :: iobs
        !! Handle of an observation set
        integer, intent(inout) :: n(4)          !! Accelerometer, star camera, magnetometer, orbit
        type(c_error_t), intent(inout) :: error
        integer(c_int) :: status                !! A gracecg_status

        integer(c_size_t) :: counts(4)

        counts = 0
        status = c_observations_counts(iobs, counts, error)
        n = int(counts)
    end function observation_counts

    !> An observation set from arrays; those that end with their own size.
    function observation_arrays(iset, na, ta, a, ns, ts, ihead, q, nm, tm, b, no, to, xo, iobs, error) result(status)
        integer(c_intptr_t), intent(in) :: iset
        !! Handle of an observation set
        integer, intent(in) :: na, ns, nm, no           !! Samples
        real(dp), intent(in) :: ta(*), a(3, *)          !! Accelerometer: s; body axes, m/s^2
        real(dp), intent(in) :: ts(*), q(4, *)          !! Star camera: s; inertial to camera, scalar last
        integer, intent(in) :: ihead(*)                 !! 1 or 2
        real(dp), intent(in) :: tm(*), b(3, *)          !! Magnetometer: s; body axes, T
        real(dp), intent(in) :: to(*), xo(3, *)         !! Orbit: s; inertial, m
        integer(c_intptr_t), intent(out) :: iobs        !! 0 when it fails
        type(c_error_t), intent(inout) :: error
        integer(c_int) :: status                        !! A gracecg_status

        call start(status, error)
        iobs = 0
        if (min(na, ns, nm, no) < 0) then
            call raise(STATUS_BAD_SIZE, 'a number of samples is negative', status, error)
        else
            call create_observations(iset, ta(:na), a(:, :na), ts(:ns), ihead(:ns), q(:, :ns), tm(:nm), &
                                     b(:, :nm), to(:no), xo(:, :no), iobs, status, error)
        end if
    end function observation_arrays

    !> A setup with measured moments of the rods.
    function measured_setup(iset, n, t, xm, isetm, error) result(status)
        integer(c_intptr_t), intent(in) :: iset
        !! Handle of a setup
        integer, intent(in) :: n                        !! Samples
        real(dp), intent(in) :: t(*), xm(3, *)          !! s; along the rods, A m^2
        integer(c_intptr_t), intent(out) :: isetm       !! 0 when it fails
        type(c_error_t), intent(inout) :: error
        integer(c_int) :: status                        !! A gracecg_status

        call start(status, error)
        isetm = 0
        if (n < 0) then
            call raise(STATUS_BAD_SIZE, 'a number of samples is negative', status, error)
        else
            call setup_with_moments(iset, t(:n), xm(:, :n), isetm, status, error)
        end if
    end function measured_setup

    !> An estimate; with STATUS_OK the message holds its warnings.
    function estimate_arrays(algo, iobs, d, cov, rms, cond, niter, iconv, error) result(status)
        character(*), intent(in) :: algo                !! As C wants it
        integer(c_intptr_t), intent(in) :: iobs
        !! Handle of an observation set
        real(dp), intent(inout) :: d(3), cov(3, 3)      !! Offset and covariance, m, m^2
        real(dp), intent(inout) :: rms(3), cond         !! Of the residuals, m/s^2; condition number
        integer, intent(inout) :: niter, iconv          !! Iterations; 1: converged
        type(c_error_t), intent(inout) :: error
        integer(c_int) :: status                        !! A gracecg_status

        character(kind=c_char) :: warnings(MESSAGE_SIZE)
        type(c_solution_t) :: solution

        warnings(1) = c_null_char
        status = c_estimate(algo, iobs, solution, warnings, size(warnings, kind=c_size_t), error)
        if (status == STATUS_OK) error%message = warnings
        if (status /= STATUS_OK .and. status /= STATUS_NOT_CONVERGED) return
        d = solution%offset
        cov = solution%covariance
        rms = solution%residual_rms
        cond = solution%condition
        niter = solution%iterations
        iconv = solution%converged
    end function estimate_arrays

    !> What the data say of the operator's beliefs.
    function belief_arrays(algo, iobs, und, apart, ntest, ncon, nunt, error) result(status)
        character(*), intent(in) :: algo                !! As C wants it
        integer(c_intptr_t), intent(in) :: iobs         !! Handle of an observation set
        real(dp), intent(inout) :: und(3), apart(3)     !! Undetected effect, difference from `optimal`, m
        integer, intent(inout) :: ntest, ncon, nunt     !! Tested, contradicted, not testable here
        type(c_error_t), intent(inout) :: error
        integer(c_int) :: status                        !! A gracecg_status

        character(kind=c_char) :: text(MESSAGE_SIZE)
        type(c_beliefs_t) :: beliefs

        text(1) = c_null_char
        status = c_test_beliefs(algo, iobs, beliefs, text, size(text, kind=c_size_t), error)
        if (status /= STATUS_OK) return
        error%message = text
        und = beliefs%undetected
        apart = beliefs%apart
        ntest = beliefs%tested
        ncon = beliefs%contradicted
        nunt = beliefs%untested
    end function belief_arrays

    !> The bound of a case.
    function bound_arrays(icas, sig, cov, psig, dir, csig, error) result(status)
        integer(c_intptr_t), intent(in) :: icas
        !! Handle of a case
        real(dp), intent(inout) :: sig(3), cov(3, 3)    !! m, m^2
        real(dp), intent(inout) :: psig(3), dir(3, 3)   !! Of the error ellipsoid, m; directions as columns
        real(dp), intent(inout) :: csig(3)              !! With what is known only within limits, m
        type(c_error_t), intent(inout) :: error
        integer(c_int) :: status                        !! A gracecg_status

        type(c_bound_t) :: bound

        status = c_case_bound(icas, bound, error)
        if (status /= STATUS_OK) return
        sig = bound%sigma
        cov = bound%covariance
        psig = bound%principal_sigma
        dir = bound%direction
        csig = bound%consider_sigma
    end function bound_arrays

    !> The settings of the planner for a case.
    function design_defaults_arrays(icas, opt, iopt, error) result(status)
        integer(c_intptr_t), intent(in) :: icas
        !! Handle of a case
        real(dp), intent(inout) :: opt(9)               !! The numbers of c_design_settings_t in their order
        integer, intent(inout) :: iopt(8)               !! Its integers likewise
        type(c_error_t), intent(inout) :: error
        integer(c_int) :: status                        !! A gracecg_status

        type(c_design_settings_t) :: settings

        status = c_design_defaults(icas, settings, error)
        if (status /= STATUS_OK) return
        opt = [settings%start, settings%duration, settings%amplitude, settings%lowest_frequency, &
               settings%highest_frequency, settings%taper, settings%rise_time, settings%rate_limit, &
               settings%pointing_limit]
        iopt = [settings%rod_used, settings%waveform_used, settings%threads]
    end function design_defaults_arrays

    !> Searches a manoeuvre with settings as design_defaults_arrays gives them.
    function design_arrays(icas, opt, iopt, jcas, sig, wave, frc, amot, error) result(status)
        integer(c_intptr_t), intent(in) :: icas
        !! Handle of a case
        real(dp), intent(in) :: opt(9)
        !! Real settings of the search, see docs/api.md
        integer, intent(in) :: iopt(8)
        !! Integer settings of the search, see docs/api.md
        integer(c_intptr_t), intent(inout) :: jcas      !! The case with the manoeuvre
        real(dp), intent(inout) :: sig(3), wave(3), frc(3)    !! Limit; errors by wave and forces, m
        real(dp), intent(inout) :: amot(2)              !! Greatest angular velocity, rad/s, and turn, rad
        type(c_error_t), intent(inout) :: error
        integer(c_int) :: status                        !! A gracecg_status

        type(c_design_t) :: design

        status = c_design_manoeuvre(icas, c_design_settings_t(opt(1), opt(2), opt(3), opt(4), opt(5), opt(6), &
                                                              opt(7), opt(8), opt(9), iopt(1:3), iopt(4:7), &
                                                              iopt(8)), jcas, design, error)
        if (status /= STATUS_OK) return
        sig = design%sigma
        wave = design%wave
        frc = design%force
        amot = [design%rate, design%excursion]
    end function design_arrays

    !> The same along the orbit.
    function design_along_arrays(icas, opt, iopt, iplace, nrev, jcas, t, sig, wave, frc, amot, error) result(status)
        integer(c_intptr_t), intent(in) :: icas         !! Handle of a case
        real(dp), intent(in) :: opt(9)                  !! Real settings of the search, see docs/api.md
        integer, intent(in) :: iopt(8)                  !! Integer settings of the search, see docs/api.md
        integer, intent(in) :: iplace, nrev             !! 2: the best start; 3: one for all; revolutions
        integer(c_intptr_t), intent(inout) :: jcas      !! The case with the manoeuvre
        real(dp), intent(inout) :: t                    !! Its start, s from the epoch of the first
        real(dp), intent(inout) :: sig(3), wave(3), frc(3)    !! Limit; errors by wave and forces, m
        real(dp), intent(inout) :: amot(2)              !! Greatest angular velocity, rad/s, and turn, rad
        type(c_error_t), intent(inout) :: error
        integer(c_int) :: status                        !! A gracecg_status

        type(c_design_t) :: design

        status = c_design_along(icas, c_design_settings_t(opt(1), opt(2), opt(3), opt(4), opt(5), opt(6), opt(7), opt(8), &
                                                          opt(9), iopt(1:3), iopt(4:7), iopt(8)), iplace, nrev, jcas, &
                                design, t, error)
        if (status /= STATUS_OK) return
        sig = design%sigma
        wave = design%wave
        frc = design%force
        amot = [design%rate, design%excursion]
    end function design_along_arrays

    !> The residuals of an estimate, a column a sample.
    function residual_arrays(algo, iobs, nmax, n, t, res, error) result(status)
        character(*), intent(in) :: algo                !! As C wants it
        integer(c_intptr_t), intent(in) :: iobs         !! Handle of an observation set
        integer, intent(in) :: nmax                     !! Columns of the arrays
        integer, intent(inout) :: n                     !! Samples
        real(dp), intent(inout) :: t(*), res(3, *)      !! s from the epoch; observed minus fitted, body axes, m/s^2
        type(c_error_t), intent(inout) :: error
        integer(c_int) :: status                        !! A gracecg_status

        integer(c_intptr_t) :: fit
        integer(c_size_t) :: samples

        call open_fit(algo, iobs, nmax, fit, status, error)
        if (status /= STATUS_OK) return
        status = c_fit_counts(fit, samples, error=error)
        n = int(samples)
        if (status == STATUS_OK) status = c_fit_series(fit, int(nmax, c_size_t), t, res, error=error)
        call close_fit(fit)
    end function residual_arrays

    !> The running estimate of `sequential`, a column an epoch.
    function running_arrays(iobs, nmax, n, t, d, sig, error) result(status)
        integer(c_intptr_t), intent(in) :: iobs         !! Handle of an observation set
        integer, intent(in) :: nmax                     !! Columns of the arrays
        integer, intent(inout) :: n                     !! Epochs
        real(dp), intent(inout) :: t(*), d(3, *), sig(3, *)     !! s from the epoch; offset and standard deviation, m
        type(c_error_t), intent(inout) :: error
        integer(c_int) :: status                        !! A gracecg_status

        integer(c_intptr_t) :: fit
        integer(c_size_t) :: running

        call open_fit(c_text('sequential'), iobs, nmax, fit, status, error)
        if (status /= STATUS_OK) return
        status = c_fit_counts(fit, running=running, error=error)
        n = int(running)
        if (status == STATUS_OK) status = c_fit_running(fit, int(nmax, c_size_t), t, d, sig, error)
        call close_fit(fit)
    end function running_arrays

    !> A fit, if the arrays can have columns at all.
    subroutine open_fit(algo, iobs, nmax, fit, status, error)
        character(*), intent(in) :: algo                !! As C wants it
        integer(c_intptr_t), intent(in) :: iobs         !! Handle of an observation set
        integer, intent(in) :: nmax
        integer(c_intptr_t), intent(out) :: fit
        integer(c_int), intent(out) :: status           !! A gracecg_status
        type(c_error_t), intent(inout) :: error

        fit = 0
        call start(status, error)
        if (nmax < 0) then
            call raise(STATUS_BAD_SIZE, 'a number of columns is negative', status, error)
        else
            status = c_fit_open(algo, iobs, fit, error)
        end if
    end subroutine open_fit

    !> Gives a fit back, and leaves status and message as they are.
    subroutine close_fit(fit)
        integer(c_intptr_t), intent(inout) :: fit

        integer(c_int) :: status

        status = c_fit_free(fit)
    end subroutine close_fit

    !> The rotation from inertial to Earth-fixed axes, to be multiplied by a column.
    function orientation_array(mjd, sec, dut1, pole, t, rot, error) result(status)
        integer, intent(in) :: mjd                      !! Modified Julian day, UTC
        real(dp), intent(in) :: sec                     !! Of that day, s
        real(dp), intent(in) :: dut1, pole(2), t        !! UT1-UTC, s; x and y of the pole, rad; s after that time
        real(dp), intent(inout) :: rot(3, 3)            !! Earth-fixed from inertial, as Fortran has it
        type(c_error_t), intent(inout) :: error
        integer(c_int) :: status                        !! A gracecg_status

        real(dp) :: rows(3, 3)

        rows = 0
        status = c_earth_orientation(c_utc_t(mjd, sec), dut1, pole, t, rows, error)
        if (status == STATUS_OK) rot = transpose(rows)
    end function orientation_array

    !> The torque rods of a case, one a column.
    function rod_arrays(icas, nmax, n, rod, irod, error) result(status)
        integer(c_intptr_t), intent(in) :: icas
        !! Handle of a case
        integer, intent(in) :: nmax                     !! Columns of the arrays
        integer, intent(inout) :: n                     !! Activations
        real(dp), intent(inout) :: rod(7, *)            !! The numbers of c_rod_t in their order
        integer, intent(inout) :: irod(2, *)            !! Its integers likewise
        type(c_error_t), intent(inout) :: error
        integer(c_int) :: status                        !! A gracecg_status

        type(c_rod_t), allocatable :: rods(:)
        integer(c_size_t) :: count
        integer :: i

        count = 0
        call start(status, error)
        if (nmax < 0) then
            call raise(STATUS_BAD_SIZE, 'a number of columns is negative', status, error)
        else
            status = c_case_rods(icas, 0_c_size_t, count, error=error)
        end if
        n = int(count)
        if (status /= STATUS_OK) return
        allocate (rods(count))
        status = c_case_rods(icas, int(min(n, nmax), c_size_t), count, rods, error)
        if (status /= STATUS_OK) return
        do i = 1, n
            rod(:, i) = [rods(i)%amplitude, rods(i)%frequency, rods(i)%phase, rods(i)%start, rods(i)%stop, &
                         rods(i)%taper, rods(i)%rise_time]
            irod(:, i) = [rods(i)%axis, rods(i)%waveform]
        end do
    end function rod_arrays

    !> The manoeuvre of a case at places of its orbit, one a column.
    function map_arrays(icas, nplc, t, nthr, plc, sig, wrst, error) result(status)
        integer(c_intptr_t), intent(in) :: icas
        !! Handle of a case
        integer, intent(in) :: nplc                     !! Places
        real(dp), intent(in) :: t(*)                    !! Starts of the calibration, s from the case's epoch
        integer, intent(in) :: nthr                     !! Threads
        real(dp), intent(inout) :: plc(2, *), sig(3, *) !! Latitude and longitude, rad; standard deviations, m
        real(dp), intent(inout) :: wrst(4, *)           !! Worst direction: standard deviation (m), unit vector
        type(c_error_t), intent(inout) :: error
        integer(c_int) :: status                        !! A gracecg_status

        real(dp), allocatable :: latitude(:), longitude(:), worst(:), direction(:, :)

        call start(status, error)
        if (nplc < 0) then
            call raise(STATUS_BAD_SIZE, 'the number of places is negative', status, error)
            return
        end if
        allocate (latitude(nplc), longitude(nplc), worst(nplc), direction(3, nplc))
        status = c_map(icas, int(nplc, c_size_t), t(:nplc), nthr, latitude, longitude, sig, worst, direction, &
                       error=error)
        if (status /= STATUS_OK) return
        plc(1, :nplc) = latitude
        plc(2, :nplc) = longitude
        wrst(1, :nplc) = worst
        wrst(2:4, :nplc) = direction
    end function map_arrays
end module gracecg_interface_f77_support
