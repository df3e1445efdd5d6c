!> What an operator is to do after a calibration, first of all: move the masses, leave them, calibrate again, or not use
!> the offset; and why, in one line.
module gracecg_estimation_action
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: MILLIMETRE, AXES
    use gracecg_base_statistics, only: order_of
    use gracecg_base_text, only: rounded_text, join, pick_text
    use gracecg_estimation_belief_report, only: belief_report_t
    use gracecg_estimation_belief_words, only: say_value
    implicit none
    private
    public :: action_t, known_offset_t, known_of, decide, refuse_offset, listed_axes, ACTIONS, WANTED_ACCURACY
    public :: TRIM_IT, LEAVE_IT, CALIBRATE_AGAIN, DO_NOT_USE, NOT_TESTED

    integer, parameter :: TRIM_IT = 1           !! Move the centre of mass along some axes
    integer, parameter :: LEAVE_IT = 2          !! The offset is as small as can be told, on every axis
    integer, parameter :: CALIBRATE_AGAIN = 3   !! Nothing can be moved, and some axis is not known well enough
    integer, parameter :: DO_NOT_USE = 4        !! Something is wrong
    integer, parameter :: NOT_TESTED = 5        !! The options leave out the tests that an action rests on
    !> The five in words
    character(15), parameter :: ACTIONS(5) = [character(15) :: 'trim', 'leave', 'calibrate again', 'do not use', 'not tested']

    real(dp), parameter :: WANTED_ACCURACY = 1e-4_dp
    !! Of each component of the offset, m: what CSR-TM-00-01 Table 1.2 asks of its stability
    real(dp), parameter :: NOT_ZERO = 3         !! Standard deviations of a component that is not 0

    !> What is known of an offset.
    type :: known_offset_t
        real(dp) :: value(3) = 0            !! d, from centre of mass to proof mass, body axes, m
        real(dp) :: sigma(3) = 0            !! With all that is known to be left out of the fit's, m
        real(dp) :: unseen(3) = 0           !! What could move it without any test seeing it, m
        character(48) :: hidden(3) = ''     !! By what
        character(120) :: suspicion(3) = ''
        !! The value of that by the data, in words, where they contradict it if all else is exact
        real(dp) :: tolerated = 0           !! Of `unseen`, m
        logical :: signs_known = .false.    !! Of the accelerometer's axes
        logical :: signs_seen = .false.     !! The samples confirm them: nobody's word is needed
    end type known_offset_t

    !> What to do.
    type :: action_t
        integer :: kind = DO_NOT_USE            !! One of the five
        logical :: trimmed(3) = .false.         !! Axes along which the centre of mass is to be moved by d
        logical :: again(3) = .false.           !! Axes that take another calibration
        real(dp) :: sigma(3) = 0                !! That it rests on, m; 0: not known
        character(:), allocatable :: text       !! One line: what, and why
    end type action_t

contains

    !> What is known of an offset by its covariance and tests.
    function known_of(offset, covariance, report) result(known)
        real(dp), intent(in) :: offset(3), covariance(3, 3)     !! d, m; m^2
        type(belief_report_t), intent(in) :: report
        type(known_offset_t) :: known

        character(:), allocatable :: text
        integer :: i

        known%value = offset
        known%sigma = [(sqrt(covariance(i, i) + report%apart(i)**2 + report%stated(i)**2), i=1, 3)]
        do i = 1, 3
            if (size(report%values) == 0) exit
            associate (test => report%values(report%largest_within(i)))
                known%unseen(i) = abs(test%within(i))
                known%hidden(i) = test%subject
                if (abs(test%score) <= report%critical .or. test%all_or_nothing) cycle
                call say_value(test%subject, test%belief, test%value, test%sigma, text)
                known%suspicion(i) = text
            end associate
        end do
        known%tolerated = report%wanted
        known%signs_known = report%signs_known
    end function known_of

    !> The action for an offset that nothing contradicts. Each axis is taken for itself: it is moved if its sigma, and what
    !> could hide, are as small as wanted, and it differs from 0. What could hide grows with the offset: of a large one it may be
    !> a tenth, and another calibration follows.
    subroutine decide(known, mass, action)
        type(known_offset_t), intent(in) :: known
        real(dp), intent(in) :: mass                !! Of the satellite, kg
        type(action_t), intent(out) :: action

        character(30) :: moves(3), sigmas(3), moments(3)
        character(:), allocatable :: why
        real(dp), parameter :: LARGE = 1e-3_dp, PART = 0.1_dp       ! m; chosen
        logical :: good(3), moved(3), rough(3)
        integer :: axis

        good = known%sigma <= WANTED_ACCURACY .and. known%unseen <= &
               max(known%tolerated, merge(PART*abs(known%value), 0.0_dp, abs(known%value) > LARGE))
        rough = good .and. known%unseen > known%tolerated
        moved = good .and. abs(known%value) > NOT_ZERO*known%sigma
        action%again = rough .or. .not. good
        if (any(moved) .and. .not. known%signs_known) then
            action%again = .true.
            action%kind = CALIBRATE_AGAIN
            action%text = 'calibrate again after a small known move of the masses (no calibration alone tells whether the '// &
                'accelerometer''s axes have the signs and order of the setup; once a move has shown it, say '// &
                'signs_known = .true. there)'
            return
        end if
        action%trimmed = moved
        action%sigma = known%sigma
        action%kind = merge(TRIM_IT, merge(LEAVE_IT, CALIBRATE_AGAIN, all(good)), any(moved))
        do axis = 1, 3
            moves(axis) = trim(signed(known%value(axis)/MILLIMETRE))//' mm along '//AXES(axis)
            sigmas(axis) = rounded_text(known%sigma(axis)/MILLIMETRE, 2)
            moments(axis) = signed(mass*known%value(axis)/MILLIMETRE)
        end do
        action%text = ''
        if (any(moved)) call append('trim: move the centre of mass by '//join(pack(moves, moved), ', ')//' (sigma '// &
                                    join(pack(sigmas, moved), ', ')//' mm; mass moments '//join(pack(moments, moved), ', ')// &
                                    ' kg mm), if the setup '//pick_text(known%signs_seen, 'holds (mass and common '// &
                                    'scale of the accelerometer are not tested)', 'and its accelerometer signs hold'))
        if (any(rough)) call append('then calibrate again for '//trim(listed_axes(rough))//' (unseen could be up to a tenth '// &
                                    'of so large an offset)')
        if (any(good .and. .not. moved)) call append('leave '//trim(listed_axes(good .and. .not. moved))//' (within '// &
                                                    rounded_text(NOT_ZERO, 2)//' sigma of 0)')
        if (.not. all(good)) then
            call say_reasons(why)
            call append('calibrate again for '//trim(listed_axes(.not. good))//' ('//why//')')
        end if

    contains

        !> Why axes are not good: what the data say to be wrong first, the largest first, axes with the same reason together.
        subroutine say_reasons(text)
            character(:), allocatable, intent(out) :: text

            character(:), allocatable :: part, effect
            logical :: alike(3), told(3), suspicious
            integer :: order(3), pass, k, i

            text = ''
            told = known%sigma <= WANTED_ACCURACY       ! but for what is hidden
            order = order_of(merge(-known%unseen, -huge(1.0_dp), told))
            do pass = 1, 2
                do k = 1, 3
                    i = order(k)
                    suspicious = told(i) .and. known%suspicion(i) /= ''
                    if (good(i) .or. (suspicious .neqv. pass == 1)) cycle
                    alike = .not. good .and. told .and. known%hidden == known%hidden(i)
                    if (told(i) .and. maxloc(known%unseen, 1, mask=alike) /= i) cycle
                    effect = rounded_text(known%unseen(i)/MILLIMETRE, 2)//' mm of '//trim(listed_axes(alike))
                    if (.not. told(i)) then
                        part = 'sigma of '//AXES(i)//' '//trim(sigmas(i))//' mm, wanted '// &
                            rounded_text(WANTED_ACCURACY/MILLIMETRE, 2)
                    else if (suspicious) then
                        part = trim(known%suspicion(i))//' by the data: '//effect
                        if (text == '') part = 'check the setup: '//part
                    else
                        part = 'unseen could be '//effect//' by '//trim(known%hidden(i))//', wanted '// &
                            rounded_text(known%tolerated/MILLIMETRE, 2)
                    end if
                    if (text /= '') text = text//', '
                    text = text//part
                end do
            end do
        end subroutine say_reasons

        subroutine append(part)
            character(*), intent(in) :: part

            if (action%text /= '') action%text = action%text//'; '
            action%text = action%text//part
        end subroutine append
    end subroutine decide

    !> The action for an offset that is not to be used.
    subroutine refuse_offset(reason, action)
        character(*), intent(in) :: reason      !! Without a full stop
        type(action_t), intent(out) :: action

        action%kind = DO_NOT_USE
        action%again = .true.
        action%text = 'do not use: '//reason
    end subroutine refuse_offset

    !> A number with its sign, and blanks behind it.
    function signed(value) result(text)
        real(dp), intent(in) :: value
        character(12) :: text

        text = rounded_text(value, 3)
        if (value > 0) text = '+'//text
    end function signed

    !> The axes that are chosen: 'x', 'x and z'.
    function listed_axes(chosen) result(text)
        logical, intent(in) :: chosen(3)        !! x, y, z
        character(10) :: text

        character(1), allocatable :: names(:)

        names = pack(AXES, chosen)
        associate (n => size(names))
            text = ''
            if (n == 1) text = names(1)
            if (n > 1) text = join(names(:n - 1), ', ')//' and '//names(n)
        end associate
    end function listed_axes
end module gracecg_estimation_action
