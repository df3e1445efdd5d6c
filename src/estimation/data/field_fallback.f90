!> The geomagnetic field without a magnetometer, CSR-TM-00-01 sections 4.7 and 6.4: from a model (IGRF)
!> at the satellite's place, which GPS gives, turned to body axes by the star camera's attitude.
!>
!> Between the orbit's positions a cubic is laid through four of them. In low orbits its error is
!> below 1 mm for positions every 5 s and 6 m for the longest spacing allowed, 60 s, which is 0.12 nT
!> (the field changes by 0.02 nT/m). The star camera's noise, some 1e-4 rad, turns the field by a few
!> nT. The error of the model itself is larger by far: the report assumes 150 nT along each axis.
module gracecg_estimation_field_fallback
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: NANOTESLA
    use gracecg_base_error, only: error_t, fail, add_context, number_text
    use gracecg_base_statistics, only: order_of
    use gracecg_base_text, only: string_t, append, integer_text, join
    use gracecg_base_quaternion, only: rotation_matrix, normalised
    use gracecg_environment_earth_orientation, only: earth_orientation_t, new_earth_orientation
    use gracecg_environment_time, only: decimal_year, time_tag
    use gracecg_environment_geomagnetic_field, only: geomagnetic_model_t
    use gracecg_environment_geomagnetic_models, only: new_geomagnetic_model, GEOMAGNETIC_MODELS
    use gracecg_observations_knowledge, only: NO_FIELD_MODEL
    use gracecg_observations_observation_set, only: observation_set_t, has_orbit
    use gracecg_estimation_interpolation, only: interpolation_t, interpolation_at, interpolated, is_covered, &
        cubic_interpolated, LONGEST_ORBIT_SPACING
    use gracecg_estimation_star_attitude, only: star_attitude_t
    implicit none
    private
    public :: complete_field, compare_field

    !> The model along the arc.
    type :: model_field_t
        class(geomagnetic_model_t), allocatable :: geomagnetic
        type(earth_orientation_t) :: earth          !! In inertial axes
        real(dp), allocatable :: orbit_time(:)      !! s
        real(dp), allocatable :: position(:, :)     !! Inertial, m
        type(star_attitude_t) :: stars
        real(dp) :: star_camera_interval = 0        !! s
    contains
        procedure :: evaluate
    end type model_field_t

    real(dp), parameter :: LONGEST_ATTITUDE_GAP = 30.0_dp
    !! Between star-camera samples, s. The chord across a gap g misses the attitude by g^2/8 times the
    !! angular acceleration of up to 2e-5 rad/s^2: 2e-3 rad, or 60 nT, at most
    integer, parameter :: FEWEST_COMMON = 5     !! Epochs that determine an offset of the model
    integer, parameter :: ENOUGH = 64
    !! Epochs that tell whether both belong together: all of a minute, so that what rods leak into the magnetometer cancels
    real(dp), parameter :: SLACK = 1e-6_dp      !! Of an interval, for rounding

contains

    !> The magnetometer's series without gaps: at its epochs k times the sampling interval that
    !> samples are missing for, and that interpolation does not bridge, the model's field is put in.
    !> If magnetometer and model have at least five epochs in common, the mean of their difference
    !> there (body axes) is added to the model: the magnetometer's bias, and what the model lacks.
    !> Without an orbit the series stays as it is.
    !>
    !> Fails when the setup names no model or the model does not hold at the epoch, and where the
    !> orbit or the attitude does not reach.
    subroutine complete_field(observations, stars, times, field, warnings, error)
        type(observation_set_t), intent(in) :: observations
        type(star_attitude_t), intent(in) :: stars
        real(dp), allocatable, intent(out) :: times(:)      !! s
        real(dp), allocatable, intent(out) :: field(:, :)   !! (3, times), body axes, T
        type(string_t), allocatable, intent(inout) :: warnings(:)
        type(error_t), allocatable, intent(out) :: error

        type(model_field_t) :: model
        real(dp), allocatable :: missing(:), missing_field(:, :)
        real(dp) :: offset(3)
        integer, allocatable :: order(:)
        integer :: i, common

        times = observations%magnetometer_time
        field = observations%field
        if (.not. has_orbit(observations)) return
        missing = missing_epochs(observations)
        if (size(missing) == 0) return
        call new_model_field(observations, stars, model, error)
        if (allocated(error)) return
        call find_offset(model, observations, 1, offset, common)
        allocate (missing_field(3, size(missing)))
        do i = 1, size(missing)
            call model%evaluate(missing(i), missing_field(:, i), error)
            call add_context(error, 'magnetometer: samples are missing, and the model cannot stand in')
            if (allocated(error)) return
            missing_field(:, i) = missing_field(:, i) + offset
        end do
        times = [times, missing]
        field = reshape([field, missing_field], [3, size(times)])
        order = order_of(times)
        times = times(order)
        field = field(:, order)
        call append(warnings, 'magnetometer: no samples for '//integer_text(size(missing))// &
                    trim(merge(' epoch ', ' epochs', size(missing) == 1))//' from '//number_text(missing(1))//' s to '// &
                    number_text(missing(size(missing)))//' s; '//trim(observations%knowledge%field_model)//' stands in'// &
                    trim(offset_text(offset, common))//'; the sigmas leave out the error of the model')
    end subroutine complete_field

    !> The mean field that the magnetometer shows, and that of the model at the same epochs: magnetometer, orbit, attitude and
    !> clock of one satellite at one time agree. Nothing where there is no orbit, no model, or too few epochs.
    subroutine compare_field(observations, stars, seen, modelled, compared)
        type(observation_set_t), intent(in) :: observations
        type(star_attitude_t), intent(in) :: stars
        real(dp), intent(out) :: seen(3), modelled(3)       !! Body axes, T
        logical, intent(out) :: compared        !! Both are known

        type(model_field_t) :: model
        type(error_t), allocatable :: no_model
        real(dp) :: offset(3)
        integer :: common

        seen = 0
        modelled = 0
        compared = .false.
        if (.not. has_orbit(observations) .or. size(observations%magnetometer_time) < FEWEST_COMMON) return
        call new_model_field(observations, stars, model, no_model)
        if (allocated(no_model)) return
        call find_offset(model, observations, max(1, size(observations%magnetometer_time)/ENOUGH), offset, common)
        compared = common >= FEWEST_COMMON
        seen = sum(observations%field, 2)/size(observations%field, 2)
        modelled = seen - offset
    end subroutine compare_field

    !> The magnetometer's epochs that its samples do not cover; before the first sample, where interpolation would reach, but
    !> not to the beginning of the arc, all.
    pure function missing_epochs(observations) result(missing)
        type(observation_set_t), intent(in) :: observations
        real(dp), allocatable :: missing(:)     !! s

        real(dp), allocatable :: epochs(:)
        integer :: k

        associate (interval => observations%knowledge%magnetometer_interval)
            epochs = [(time_tag(k, interval), k=1, int(observations%knowledge%duration/interval + SLACK))]
            missing = pack(epochs, [(.not. is_covered(observations%magnetometer_time, epochs(k), interval), &
                                     k=1, size(epochs))] .or. epochs < minval(observations%magnetometer_time) - interval/2)
        end associate
    end function missing_epochs

    subroutine new_model_field(observations, stars, model, error)
        type(observation_set_t), intent(in) :: observations
        type(star_attitude_t), intent(in) :: stars
        type(model_field_t), intent(out) :: model
        type(error_t), allocatable, intent(out) :: error

        associate (knowledge => observations%knowledge)
            if (knowledge%field_model == NO_FIELD_MODEL) then
                call fail(error, 'magnetometer: samples are missing, and the setup names no '// &
                          'geomagnetic field model that could stand in ('//join(GEOMAGNETIC_MODELS, ' or ')//')')
                return
            end if
            call new_geomagnetic_model(trim(knowledge%field_model), decimal_year(knowledge%epoch), '', &
                                       model%geomagnetic, error)
            call add_context(error, 'magnetometer: samples are missing, and the model cannot stand in')
            if (allocated(error)) return
            call new_earth_orientation(trim(knowledge%earth_orientation), knowledge%epoch, knowledge%sidereal_angle, &
                                       knowledge%earth_parameters, model%earth, error)
            model%star_camera_interval = knowledge%star_camera_interval
        end associate
        model%orbit_time = observations%orbit_time
        model%position = observations%orbit_position
        model%stars = stars
    end subroutine new_model_field

    !> The model's field in body axes (2-30). Fails where the orbit or the attitude does not reach.
    subroutine evaluate(self, t, b, error)
        class(model_field_t), intent(in) :: self
        real(dp), intent(in) :: t               !! s
        real(dp), intent(out) :: b(3)           !! Body axes, T
        type(error_t), allocatable, intent(out) :: error

        type(interpolation_t) :: place, attitude
        real(dp) :: earth_from_inertial(3, 3), q(4)

        b = 0
        place = interpolation_at(self%orbit_time, t, 0.0_dp, LONGEST_ORBIT_SPACING)
        if (.not. place%supported) then
            call fail(error, 'orbit: no positions around '//number_text(t)//' s; they must reach '// &
                      'over the arc, at most '//number_text(LONGEST_ORBIT_SPACING)//' s apart')
            return
        end if
        attitude = interpolation_at(self%stars%time, t, self%star_camera_interval, LONGEST_ATTITUDE_GAP)
        if (.not. attitude%supported) then
            call fail(error, 'star camera: no attitude near '//number_text(t)// &
                      ' s to turn the field into body axes')
            return
        end if
        earth_from_inertial = self%earth%from_inertial(t)
        call self%geomagnetic%evaluate(matmul(earth_from_inertial, &
                                       cubic_interpolated(self%orbit_time, self%position, t)), b)
        q = normalised(interpolated(self%stars%quaternion, attitude))
        b = matmul(rotation_matrix(q), matmul(b, earth_from_inertial))
    end subroutine evaluate

    !> The mean of magnetometer minus model over the magnetometer's samples, those left out where orbit
    !> or attitude do not reach; zero when there are too few.
    subroutine find_offset(model, observations, stride, offset, common)
        type(model_field_t), intent(in) :: model
        type(observation_set_t), intent(in) :: observations
        integer, intent(in) :: stride           !! From sample to sample that is looked at
        real(dp), intent(out) :: offset(3)      !! Body axes, T
        integer, intent(out) :: common          !! Samples in the mean

        type(error_t), allocatable :: out_of_reach
        real(dp) :: b(3), total(3)
        integer :: i

        total = 0
        common = 0
        do i = 1, size(observations%magnetometer_time), stride
            call model%evaluate(observations%magnetometer_time(i), b, out_of_reach)
            if (allocated(out_of_reach)) cycle
            common = common + 1
            total = total + observations%field(:, i) - b
        end do
        offset = 0
        if (common >= FEWEST_COMMON) offset = total/common
    end subroutine find_offset

    function offset_text(offset, common) result(text)
        real(dp), intent(in) :: offset(3)       !! T
        integer, intent(in) :: common           !! Samples it comes from
        character(128) :: text                  !! Blanks behind it

        text = ''
        if (common < FEWEST_COMMON) return
        text = ', corrected by '//integer_text(nint(offset(1)/NANOTESLA))//', '// &
               integer_text(nint(offset(2)/NANOTESLA))//', '//integer_text(nint(offset(3)/NANOTESLA))// &
               ' nT from '//integer_text(common)//' samples of the magnetometer'
    end function offset_text
end module gracecg_estimation_field_fallback
