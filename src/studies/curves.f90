!> The verification of CSR-TM-00-01 section 5.3: the curves of Figures 5.2-5.8 along a case's arc, and
!> their comparison with the axis windows that the report prints.
module gracecg_studies_curves
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: AXES
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: pick_text
    use gracecg_files_data_table, only: data_table_t
    use gracecg_files_csv, only: unit_of_column
    use gracecg_environment_time, only: time_tag
    use gracecg_environment_thermosphere, only: density_wave_t
    use gracecg_simulation_dynamics, only: OMEGA
    use gracecg_simulation_arc, only: truth_arc_t
    use gracecg_simulation_accelerometer, only: pmc_acceleration_t
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_simulator, only: propagate_case, disturbance_at
    use gracecg_studies_table_figure_windows, only: WINDOW_SATELLITE, WINDOW_FIGURE, WINDOW_QUANTITY, WINDOW_AXIS, &
        WINDOW_LOW, WINDOW_HIGH, WINDOW_STEP
    use gracecg_studies_published, only: limits_on_ticks, same_limits, share_covered
    implicit none
    private
    public :: verification_t, verify_case, window_check_t, check_windows, window_counts_t, count_windows
    public :: curves_table, curves_file_name, curve_column, begin_windows, add_window_rows
    public :: CURVE_NAMES, WINDOW_TOLERANCE, CENTRE_TOLERANCE

    !> Names of the curves, in the order of their second index in `verification_t`
    character(20), parameter :: CURVE_NAMES(15) = [character(20) :: &
        'drag', 'srp', 'erp', 'non_gravitational', 'a_vel', 'a_gg', 'a_acc', 'a_total', 'torque_aero', &
        'torque_solar', 'torque_gravity', 'torque_magnetic', 'torque_total', 'omega', 'omega_dot']

    real(dp), parameter :: WINDOW_TOLERANCE = 0.05_dp
    !! A curve meets its window when it leaves it by at most this part of the window's width
    real(dp), parameter :: CENTRE_TOLERANCE = 0.15_dp
    !! Largest difference of a curve's mean from the window's centre, relative to the centre

    !> The curves of one case.
    type :: verification_t
        real(dp), allocatable :: time(:)            !! (epochs), s
        real(dp), allocatable :: curve(:, :, :)
        !! (axis, curve of CURVE_NAMES, epoch), body axes, m/s^2, N m, rad/s, rad/s^2
    end type verification_t

    !> One curve against its window.
    type :: window_check_t
        character(4) :: figure              !! The figure's number: '5.2'
        character(20) :: quantity           !! Name of the curve, one of CURVE_NAMES
        character(1) :: axis                !! Body axis: 'x', 'y' or 'z'
        real(dp) :: low, high               !! The printed axis limits
        real(dp) :: step                    !! Distance of the printed tick marks
        real(dp) :: least, greatest, mean   !! Of the curve
        real(dp) :: fill                    !! Share of the window that the curve covers
        real(dp) :: excess                  !! How far the curve leaves the window, of its width
        real(dp) :: centre_difference       !! |mean - centre|/|centre|; of half the width where the centre is 0
        logical :: inside                   !! excess <= WINDOW_TOLERANCE
        logical :: near_centre              !! centre_difference <= CENTRE_TOLERANCE
        logical :: on_ticks
        !! The tick marks next outside the curve are the printed limits: it stays inside, and reaches into the first
        !! and the last interval
        logical :: attitude_only            !! Depends on the attitude dynamics alone
    end type window_check_t

    !> How many curves meet their windows.
    type :: window_counts_t
        integer :: attitude = 0         !! Curves that depend on the attitude dynamics alone
        integer :: attitude_inside = 0  !! Of these, within their windows
        integer :: attitude_on_ticks = 0    !! Of these, with the printed limits at the tick marks next outside
        real(dp) :: attitude_fill = 1   !! Least share of its window that one of these covers
        integer :: surface = 0          !! The others: surface forces and torques
        integer :: surface_inside = 0   !! Of these, within their windows
        integer :: surface_on_ticks = 0     !! Of these, as of the attitude
        integer :: surface_near = 0     !! Of these, with the mean near the window's centre
    end type window_counts_t

    character(*), parameter :: PREFIX = 'verify_', SUFFIX = '.csv'  !! Of the files of curves

contains

    !> Propagates a case with its density wave and computes every curve.
    subroutine verify_case(case, verification, error)
        type(case_t), intent(in) :: case
        type(verification_t), intent(out) :: verification
        type(error_t), allocatable, intent(out) :: error

        type(case_t) :: fixed_wave
        type(truth_arc_t) :: arc
        integer :: k

        fixed_wave = case
        fixed_wave%density_wave_random = .false.
        call propagate_case(fixed_wave, arc, error)
        if (allocated(error)) return
        allocate (verification%time(0:arc%steps), verification%curve(3, size(CURVE_NAMES), 0:arc%steps))
        do k = 0, arc%steps
            verification%time(k) = time_tag(k, arc%interval)
            verification%curve(:, :, k) = curves_at(fixed_wave, arc, k)
        end do
    end subroutine verify_case

    pure function curves_at(case, arc, k) result(curve)
        type(case_t), intent(in) :: case
        type(truth_arc_t), intent(in) :: arc
        integer, intent(in) :: k
        real(dp) :: curve(3, size(CURVE_NAMES))

        type(pmc_acceleration_t) :: a

        a = disturbance_at(case, arc, density_wave_t(), k)
        associate (acting => arc%loads(k))
            curve(:, 1) = acting%drag
            curve(:, 2) = acting%srp
            curve(:, 3) = acting%erp
            curve(:, 4) = a%non_gravitational
            curve(:, 5) = a%velocity
            curve(:, 6) = a%gravity_gradient
            curve(:, 7) = a%acceleration
            curve(:, 8) = a%velocity + a%gravity_gradient + a%acceleration
            curve(:, 9) = acting%torque_aero
            curve(:, 10) = acting%torque_solar
            curve(:, 11) = acting%torque_gravity
            curve(:, 12) = acting%torque_magnetic
            curve(:, 13) = acting%torque_aero + acting%torque_solar + acting%torque_gravity + &
                           acting%torque_magnetic
            curve(:, 14) = arc%state(OMEGA, k)
            curve(:, 15) = arc%omega_dot(:, k)
        end associate
    end function curves_at

    !> Compares case 1 of a satellite with the printed windows.
    function check_windows(satellite, verification) result(checks)
        character(*), intent(in) :: satellite       !! 'front' or 'back'
        type(verification_t), intent(in) :: verification
        type(window_check_t), allocatable :: checks(:)

        integer :: i

        allocate (checks(0))
        do i = 1, size(WINDOW_LOW)
            if (WINDOW_SATELLITE(i) /= satellite) cycle
            checks = [checks, checked(i, verification)]
        end do
    end function check_windows

    function checked(i, verification) result(check)
        integer, intent(in) :: i
        type(verification_t), intent(in) :: verification
        type(window_check_t) :: check

        integer :: curve, axis
        real(dp) :: centre, reference

        curve = findloc(CURVE_NAMES == WINDOW_QUANTITY(i), .true., 1)
        axis = findloc(AXES == WINDOW_AXIS(i), .true., 1)
        check%figure = WINDOW_FIGURE(i)
        check%quantity = WINDOW_QUANTITY(i)
        check%axis = WINDOW_AXIS(i)
        check%low = WINDOW_LOW(i)
        check%high = WINDOW_HIGH(i)
        check%step = WINDOW_STEP(i)
        associate (values => verification%curve(axis, curve, :))
            check%least = minval(values)
            check%greatest = maxval(values)
            check%mean = sum(values)/size(values)
        end associate
        check%excess = max(check%low - check%least, check%greatest - check%high, 0.0_dp)/ &
                       (check%high - check%low)
        check%fill = share_covered(check%least, check%greatest, check%low, check%high)
        check%on_ticks = same_limits(limits_on_ticks(check%least, check%greatest, check%step), &
                                     [check%low, check%high], check%step)
        centre = (check%low + check%high)/2
        reference = abs(centre)
        if (centre == 0) reference = (check%high - check%low)/2
        check%centre_difference = abs(check%mean - centre)/reference
        check%inside = check%excess <= WINDOW_TOLERANCE
        check%near_centre = check%centre_difference <= CENTRE_TOLERANCE
        select case (CURVE_NAMES(curve))
        case ('drag', 'srp', 'erp', 'non_gravitational', 'torque_aero', 'torque_solar')
            check%attitude_only = .false.
        case default
            check%attitude_only = .true.
        end select
    end function checked

    !> Counts the curves that meet their windows.
    pure function count_windows(checks) result(counts)
        type(window_check_t), intent(in) :: checks(:)
        type(window_counts_t) :: counts

        associate (attitude => checks%attitude_only)
            counts%attitude = count(attitude)
            counts%attitude_inside = count(attitude .and. checks%inside)
            counts%attitude_on_ticks = count(attitude .and. checks%on_ticks)
            if (any(attitude)) counts%attitude_fill = minval(checks%fill, attitude)
            counts%surface = count(.not. attitude)
            counts%surface_on_ticks = count(.not. attitude .and. checks%on_ticks)
            counts%surface_inside = count(.not. attitude .and. checks%inside)
            counts%surface_near = count(.not. attitude .and. checks%near_centre)
        end associate
    end function count_windows

    !> verify_CASE.csv, an underscore for everything unusual in the case's name.
    pure function curves_file_name(case_name) result(name)
        character(*), intent(in) :: case_name    !! Any
        character(len(PREFIX) + len_trim(case_name) + len(SUFFIX)) :: name

        integer :: i

        name = PREFIX//trim(case_name)//SUFFIX
        do i = 1, len(name)
            select case (name(i:i))
            case ('a':'z', 'A':'Z', '0':'9', '-', '.', '_')
            case default
                name(i:i) = '_'
            end select
        end do
    end function curves_file_name

    !> The curves of Figures 5.2-5.8 of a case, body axes: a row each epoch.
    function curves_table(verification) result(table)
        type(verification_t), intent(in) :: verification
        type(data_table_t) :: table

        integer :: curve, axis, k

        call table%column('time_s')
        do curve = 1, size(CURVE_NAMES)
            do axis = 1, size(AXES)
                call table%column(trim(curve_column(CURVE_NAMES(curve), AXES(axis))))
            end do
        end do
        do k = lbound(verification%time, 1), ubound(verification%time, 1)
            call table%add([verification%time(k), verification%curve(:, :, k)])
        end do
    end function curves_table

    !> The columns of a table of curves and windows.
    subroutine begin_windows(table, compared)
        type(data_table_t), intent(inout) :: table
        logical, intent(in) :: compared             !! Its curves have windows

        call table%column('case')
        call table%column('quantity', 'a', 'quantity')
        call table%column('axis', 'a', '')
        call table%column('unit')
        call table%column('least', 'es11.4', 'least')
        call table%column('greatest', 'es11.4', 'greatest')
        call table%column('mean', pick_text(compared, '', 'es11.4'), 'mean')
        call table%column('figure')
        call table%column('low', pick_text(compared, 'es10.3', ''), 'from')
        call table%column('high', pick_text(compared, 'es10.3', ''), 'to')
        call table%column('fill', pick_text(compared, 'f4.2', ''), 'fill')
        call table%column('inside', pick_text(compared, 'a', ''), 'inside')
        call table%column('on_ticks', pick_text(compared, 'a', ''), 'ticks')
        call table%columns_of('attitude_only,excess,near_centre,centre_difference')
    end subroutine begin_windows

    !> The curves of a case against their windows, a row each.
    subroutine add_window_rows(case_name, checks, table)
        character(*), intent(in) :: case_name       !! In the first column
        type(window_check_t), intent(in) :: checks(:)
        type(data_table_t), intent(inout) :: table  !! By begin_windows; gets a row for each check

        integer :: i

        do i = 1, size(checks)
            associate (c => checks(i))
                call table%add(case_name, c%quantity, c%axis, unit_of_column(trim(curve_column(c%quantity, c%axis))))
                call table%add([c%least, c%greatest, c%mean])
                call table%add(c%figure)
                call table%add([c%low, c%high, c%fill])
                call table%add(c%inside)
                call table%add(c%on_ticks)
                call table%add(c%attitude_only)
                call table%add(c%excess)
                call table%add(c%near_centre)
                call table%add(c%centre_difference)
            end associate
        end do
    end subroutine add_window_rows

    !> The name of a curve's column: drag_x_m_s2.
    pure function curve_column(curve, axis) result(column)
        character(*), intent(in) :: curve       !! One of CURVE_NAMES
        character(*), intent(in) :: axis        !! One of AXES
        character(32) :: column

        select case (curve)
        case ('omega')
            column = 'rad_s'
        case ('omega_dot')
            column = 'rad_s2'
        case default
            column = merge('n_m ', 'm_s2', index(curve, 'torque') == 1)
        end select
        column = trim(curve)//'_'//axis//'_'//column
    end function curve_column
end module gracecg_studies_curves
