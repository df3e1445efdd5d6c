!> The C interface: bound of an estimate, planner of the manoeuvre. Documented in include/gracecg.h.
module gracecg_interface_c_planning
    use, intrinsic :: iso_c_binding, only: c_double, c_int, c_int32_t, c_intptr_t, c_size_t
    use gracecg, only: dp, error_t, calibration_t, case_bound_t, bound_of_case, BOUND_SOURCES, &
        design_settings_t, manoeuvre_design_t, plan_manoeuvre, map_case, map_point_t
    use gracecg_base_kinds, only: i8
    use gracecg_base_text, only: integer_text
    use gracecg_planning_planner, only: AT_TIME, ANYWHERE, EVERYWHERE, MOST_REVOLUTIONS
    use gracecg_interface_handles, only: object_t, acquire, release
    use gracecg_interface_c_support, only: c_error_t, STATUS_OK, STATUS_BAD_SIZE, STATUS_BAD_VALUE, start, &
        raise, pass_on, &
        need, check_count, check_finite, check_result, check_threads, refuse_handle
    use gracecg_interface_c_dynamics, only: case_object_t, keep_case
    implicit none
    private
    public :: c_bound_t, c_rod_t, c_design_settings_t, c_design_t
    public :: c_case_bound, c_case_rods, c_design_defaults, c_design_manoeuvre, c_design_along, c_map

    integer, parameter :: SOURCE_COUNT = size(BOUND_SOURCES)

    !> gracecg_bound
    type, bind(c) :: c_bound_t
        real(c_double) :: covariance(3, 3)          !! m^2
        real(c_double) :: sigma(3)                  !! m
        real(c_double) :: principal_sigma(3)        !! Ascending, m
        real(c_double) :: direction(3, 3)           !! Columns: unit vectors, the last one the worst
        real(c_double) :: consider_sigma(3)         !! m
        real(c_double) :: by_source(3, SOURCE_COUNT)  !! m
    end type c_bound_t

    !> gracecg_rod
    type, bind(c) :: c_rod_t
        real(c_double) :: amplitude                 !! A m^2
        real(c_double) :: frequency                 !! Hz
        real(c_double) :: phase                     !! rad
        real(c_double) :: start                     !! s
        real(c_double) :: stop                      !! s
        real(c_double) :: taper                     !! s
        real(c_double) :: rise_time                 !! s
        integer(c_int32_t) :: axis                  !! 1, 2 or 3
        integer(c_int32_t) :: waveform              !! 1 to 4
    end type c_rod_t

    !> gracecg_design_settings
    type, bind(c) :: c_design_settings_t
        real(c_double) :: start                     !! s
        real(c_double) :: duration                  !! s
        real(c_double) :: amplitude                 !! A m^2
        real(c_double) :: lowest_frequency          !! Hz
        real(c_double) :: highest_frequency         !! Hz
        real(c_double) :: taper                     !! s
        real(c_double) :: rise_time                 !! s
        real(c_double) :: rate_limit                !! rad/s
        real(c_double) :: pointing_limit            !! rad
        integer(c_int32_t) :: rod_used(3)           !! Not 0: yes
        integer(c_int32_t) :: waveform_used(4)      !! Not 0: yes
        integer(c_int32_t) :: threads               !! 1 and more
    end type c_design_settings_t

    !> gracecg_design
    type, bind(c) :: c_design_t
        real(c_double) :: sigma(3)                  !! m
        real(c_double) :: wave(3)                   !! m
        real(c_double) :: force(3)                  !! m
        real(c_double) :: worst                     !! m
        real(c_double) :: rate                      !! rad/s
        real(c_double) :: excursion                 !! rad
        integer(c_int32_t) :: evaluations           !! Of a manoeuvre
        integer(c_int32_t) :: reserved              !! 0
    end type c_design_t

    character(*), parameter :: CASE_NAME = 'case'
    integer, parameter :: MOST_PLACES = 1000000     !! Of a map

contains

    !> gracecg_case_bound
    function c_case_bound(handle, c_bound, error) result(status) bind(c, name='gracecg_case_bound')
        integer(c_intptr_t), intent(in), value :: handle
        type(c_bound_t), intent(inout), optional :: c_bound
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        type(case_bound_t) :: bound
        type(error_t), allocatable :: failure

        call start(status, error)
        call need(present(c_bound), 'bound', status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (case_object_t)
            call bound_of_case(object%calibration%case, object%calibration%options, bound, failure)
            call pass_on(failure, status, error)
        class default
            call refuse_handle(CASE_NAME, status, error)
        end select
        call release(int(handle, i8), object)
        call check_result([[bound%covariance], bound%sigma, bound%consider_sigma], 'the bound', status, error)
        if (status /= STATUS_OK) return
        c_bound%covariance = bound%covariance
        c_bound%sigma = bound%sigma
        c_bound%principal_sigma = bound%principal_sigma
        c_bound%direction = bound%direction
        c_bound%consider_sigma = bound%consider_sigma
        c_bound%by_source = bound%by_source
    end function c_case_bound

    !> gracecg_case_rods
    function c_case_rods(handle, capacity, count, rods, error) result(status) &
        bind(c, name='gracecg_case_rods')
        integer(c_intptr_t), intent(in), value :: handle
        integer(c_size_t), intent(in), value :: capacity
        integer(c_size_t), intent(inout), optional :: count
        type(c_rod_t), intent(inout), optional :: rods(*)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        integer :: i

        call start(status, error)
        call check_count(capacity, 'capacity', status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (case_object_t)
            associate (own => object%calibration%case%satellite%rods)
                if (present(count)) count = own%count
                if (present(rods) .and. capacity < own%count) then
                    call raise(STATUS_BAD_SIZE, 'there are '//integer_text(own%count)//' activations of rods, and '// &
                               'room for '//integer_text(int(capacity, i8)), status, error)
                else if (present(rods)) then
                    do i = 1, own%count
                        associate (rod => own%activations(i))
                            rods(i) = c_rod_t(rod%amplitude, rod%frequency, rod%phase, rod%start, rod%stop, &
                                              rod%taper, rod%rise_time, rod%axis, rod%waveform)
                        end associate
                    end do
                end if
            end associate
        class default
            call refuse_handle(CASE_NAME, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_case_rods

    !> gracecg_design_defaults
    function c_design_defaults(handle, settings, error) result(status) &
        bind(c, name='gracecg_design_defaults')
        integer(c_intptr_t), intent(in), value :: handle
        type(c_design_settings_t), intent(inout), optional :: settings
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        type(design_settings_t) :: default

        call start(status, error)
        call need(present(settings), 'settings', status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (case_object_t)
            associate (case => object%calibration%case)
                settings = c_design_settings_t(0.0_dp, case%duration, default%amplitude, &
                    default%lowest_frequency, &
                                               default%highest_frequency, default%taper, default%rise_time, &
                                               case%limits%rate, case%limits%pointing, &
                                               merge(1, 0, default%rod_used), merge(1, 0, default%waveform_used), &
                                               default%threads)
            end associate
        class default
            call refuse_handle(CASE_NAME, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_design_defaults

    !> gracecg_design_manoeuvre
    function c_design_manoeuvre(handle, settings, planned_handle, c_design, error) result(status) &
        bind(c, name='gracecg_design_manoeuvre')
        integer(c_intptr_t), intent(in), value :: handle
        type(c_design_settings_t), intent(in), optional :: settings
        integer(c_intptr_t), intent(inout), optional :: planned_handle
        type(c_design_t), intent(inout), optional :: c_design
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        call design_for(handle, settings, AT_TIME, 1, planned_handle, c_design, status, error)
    end function c_design_manoeuvre

    !> gracecg_design_along
    function c_design_along(handle, settings, place, revolutions, planned_handle, c_design, chosen, error) &
        result(status) bind(c, name='gracecg_design_along')
        integer(c_intptr_t), intent(in), value :: handle
        type(c_design_settings_t), intent(in), optional :: settings
        integer(c_int32_t), intent(in), value :: place, revolutions
        integer(c_intptr_t), intent(inout), optional :: planned_handle
        type(c_design_t), intent(inout), optional :: c_design
        real(c_double), intent(inout), optional :: chosen
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        call design_for(handle, settings, int(place), int(revolutions), planned_handle, c_design, status, error, chosen)
    end function c_design_along

    !> The search at one place or along the orbit.
    subroutine design_for(handle, settings, place, revolutions, planned_handle, c_design, status, error, chosen)
        integer(c_intptr_t), intent(in) :: handle
        type(c_design_settings_t), intent(in), optional :: settings
        integer, intent(in) :: place, revolutions           !! AT_TIME, ANYWHERE or EVERYWHERE; how many
        integer(c_intptr_t), intent(inout), optional :: planned_handle
        type(c_design_t), intent(inout), optional :: c_design
        integer(c_int), intent(out) :: status
        type(c_error_t), intent(inout), optional :: error
        real(c_double), intent(inout), optional :: chosen   !! Start, s

        real(dp) :: begin
        class(object_t), pointer :: object
        type(calibration_t) :: calibration, planned
        type(manoeuvre_design_t) :: design
        type(error_t), allocatable :: failure

        call start(status, error)
        call need(present(planned_handle), 'planned', status, error)
        if (present(planned_handle)) planned_handle = 0
        call need(present(settings), 'settings', status, error)
        call need(present(c_design), 'design', status, error)
        if (status /= STATUS_OK) return
        call check_finite([settings%start, settings%duration, settings%amplitude, settings%lowest_frequency, &
                           settings%highest_frequency, settings%taper, settings%rise_time, settings%rate_limit, &
                           settings%pointing_limit], 9_c_size_t, 'the settings', status, error)
        call check_threads(settings%threads, status, error)
        if (status == STATUS_OK .and. .not. any(place == [AT_TIME, ANYWHERE, EVERYWHERE])) &
            call raise(STATUS_BAD_VALUE, 'place = '//integer_text(place)//' has to be 1, 2 or 3', status, error)
        if (status == STATUS_OK .and. (revolutions < 1 .or. revolutions > MOST_REVOLUTIONS)) &
            call raise(STATUS_BAD_VALUE, 'revolutions = '//integer_text(revolutions)//' has to be from 1 to '// &
                       integer_text(MOST_REVOLUTIONS), status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (case_object_t)
            calibration = object%calibration
        class default
            call refuse_handle(CASE_NAME, status, error)
        end select
        call release(int(handle, i8), object)
        if (status /= STATUS_OK) return
        calibration%case%duration = settings%duration
        calibration%case%limits%rate = settings%rate_limit
        calibration%case%limits%pointing = settings%pointing_limit
        call plan_manoeuvre(calibration, settings%start, &
                            design_settings_t(rod_used=settings%rod_used /= 0, amplitude=settings%amplitude, &
                                              lowest_frequency=settings%lowest_frequency, &
                                              highest_frequency=settings%highest_frequency, &
                                              waveform_used=settings%waveform_used /= 0, taper=settings%taper, &
                                              rise_time=settings%rise_time, threads=settings%threads), &
                            planned, design, failure, place, revolutions, begin)
        call pass_on(failure, status, error)
        if (status == STATUS_OK) call keep_case(planned, planned_handle, status, error)
        if (status /= STATUS_OK) return
        c_design = c_design_t(design%sigma, design%wave, design%force, design%worst, design%rate, design%excursion, &
                              design%evaluations, 0)
        if (present(chosen)) chosen = begin
    end subroutine design_for

    !> gracecg_map
    function c_map(handle, n, seconds, threads, latitude, longitude, sigma, worst_sigma, worst_direction, wave, &
                   force, error) result(status) bind(c, name='gracecg_map')
        integer(c_intptr_t), intent(in), value :: handle
        integer(c_size_t), intent(in), value :: n
        real(c_double), intent(in), optional :: seconds(*)
        integer(c_int32_t), intent(in), value :: threads
        real(c_double), intent(inout), optional :: latitude(*), longitude(*), sigma(3, *), worst_sigma(*)
        real(c_double), intent(inout), optional :: worst_direction(3, *), wave(3, *), force(3, *)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        type(map_point_t), allocatable :: points(:)
        type(error_t), allocatable :: failure
        integer :: i

        call start(status, error)
        call check_count(n, 'n', status, error, MOST_PLACES)
        if (n > 0) call need(present(seconds), 'seconds', status, error)
        if (status /= STATUS_OK) return
        if (n > 0) call check_finite(seconds, n, 'seconds', status, error)
        call check_threads(threads, status, error)
        if (status /= STATUS_OK) return
        allocate (points(0))
        call acquire(int(handle, i8), object)
        select type (object)
        type is (case_object_t)
            if (n > 0) call map_case(object%calibration%case, seconds(:n), int(threads), points, failure)
            call pass_on(failure, status, error)
        class default
            call refuse_handle(CASE_NAME, status, error)
        end select
        call release(int(handle, i8), object)
        if (status /= STATUS_OK) return
        do i = 1, size(points)
            associate (point => points(i))
                if (present(latitude)) latitude(i) = point%latitude
                if (present(longitude)) longitude(i) = point%longitude
                if (present(sigma)) sigma(:, i) = point%quality%sigma
                if (present(worst_sigma)) worst_sigma(i) = point%worst_sigma
                if (present(worst_direction)) worst_direction(:, i) = point%worst_direction
                if (present(wave)) wave(:, i) = point%quality%wave
                if (present(force)) force(:, i) = point%quality%force
            end associate
        end do
    end function c_map
end module gracecg_interface_c_planning
